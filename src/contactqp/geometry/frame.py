"""Frame: the plane contour over which a membrane is stretched."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from functools import cached_property, lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, boolean, finite_number, positive_number
from ..foundation.limits import BYTES_TO_SOLVE, refuse_too_many
from ..foundation.loading import load_modules
from ..foundation.pictures import UnitNames, Wanted, drawn
from ..foundation.together import ALONE, Together
from .contours import crs_in, polygons_in, polygons_of, read_geojson
from .lattice import Lattice, checked_crs, refuse_indistinct, spacing_of_nodes
from .lattice_by_rows import LatticeByRows
from .on_contour import FrameFit
from .outline import Outline, circle
from .sides import Sides, is_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from shapely.geometry.base import BaseGeometry

Point = tuple[float, float]
_Grid = NDArray[np.float64]
_Inside = Callable[[_Grid, _Grid, float], Mask]
_Combine = Callable[[Any, Any], Any]

_CONTOURS_KEPT = 4
"""Moved contours that are kept, for questions about other points: a lattice is asked about some rows at a time."""

_RELATIVE_TOLERANCE = 1e-9
"""A point closer to the contour than this times the frame's extent counts as lying on it."""


class Frame:
    """A plane contour, possibly with holes and several parts.

    Make one with `rectangle`, `hexagon`, `disk`, `polygon`, `from_shapely`, `from_wkt` or `from_geojson`; join, cut and
    intersect frames with ``|``, ``-`` and ``&``. All lengths are in the unit of the lattice spacing.

    Attributes
    ----------
    geometry : shapely geometry
        The contour.
    crs : str
        Coordinate reference system of the coordinates, see `in_crs`; ``""`` if none is known.

    Examples
    --------
    >>> import contactqp as cq
    >>> plate_with_hole = cq.Frame.rectangle(4, 4) - cq.Frame.disk(1)
    >>> plate_with_hole.lattice(spacing=0.5)
    Lattice(36 nodes in 9 x 9, spacing=0.5, up to 0.29 outside its contour)
    """

    def __init__(self, geometry: BaseGeometry, inside: _Inside, name: str) -> None:
        left, bottom, right, top = map(float, geometry.bounds)
        _refuse_extremes(right - left, top - bottom, name)
        self.geometry = geometry
        self._inside = inside
        self._name = name
        self._outline: Callable[[float], Outline] = lambda spacing: Outline.of(geometry)
        self.crs = ""

    @classmethod
    def rectangle(cls, width: float, height: float, center: Point = (0.0, 0.0)) -> Frame:
        """Return a rectangle with sides along the axes, about (0, 0) unless ``center`` says otherwise.

        For corners of your own take `polygon`.

        Parameters
        ----------
        width, height : float
            Extents along x and y (length), > 0.
        center : (float, float)
            Centre (length), not the left lower corner.
        """
        load_modules("shapely.geometry")
        from shapely.geometry import box

        half_width, half_height = positive_number(width, "width") / 2, positive_number(height, "height") / 2
        center_x, center_y = _point(center, "center")

        def inside(x: _Grid, y: _Grid, margin: float) -> Mask:
            return (np.abs(x - center_x) < half_width - margin) & (np.abs(y - center_y) < half_height - margin)

        geometry = box(center_x - half_width, center_y - half_height, center_x + half_width, center_y + half_height)
        return cls(geometry, inside, f"rectangle({width:g}, {height:g})")

    @classmethod
    def disk(cls, radius: float, center: Point = (0.0, 0.0)) -> Frame:
        """Return a circle about (0, 0), unless ``center`` says otherwise.

        Nodes are judged by their exact distance from the centre.

        Parameters
        ----------
        radius : float
            Radius (length), > 0.
        center : (float, float)
            Centre (length).
        """
        load_modules("shapely.geometry")
        from shapely.geometry import Point as ShapelyPoint

        limit = positive_number(radius, "radius")
        _refuse_extremes(2 * limit, 2 * limit, f"disk({limit:g})")
        center_x, center_y = _point(center, "center")

        def inside(x: _Grid, y: _Grid, margin: float) -> Mask:
            return np.asarray(np.hypot(x - center_x, y - center_y) < limit - margin)

        geometry = ShapelyPoint(center_x, center_y).buffer(limit, quad_segs=64)
        frame = cls(geometry, inside, f"disk({radius:g})")
        frame._outline = partial(circle, limit, (center_x, center_y))
        return frame

    @classmethod
    def hexagon(cls, side: float, center: Point = (0.0, 0.0)) -> Frame:
        """Return a regular hexagon with two sides parallel to x, about (0, 0) unless ``center`` says otherwise.

        Parameters
        ----------
        side : float
            Length of a side, which is also the circumradius, > 0.
        center : (float, float)
            Centre (length).
        """
        radius = positive_number(side, "side")
        center_x, center_y = _point(center, "center")
        half, rise = radius / 2, radius * math.sqrt(3) / 2
        offsets = [(radius, 0.0), (half, rise), (-half, rise), (-radius, 0.0), (-half, -rise), (half, -rise)]
        frame = cls.polygon([(center_x + x, center_y + y) for x, y in offsets])
        frame._name = f"hexagon({side:g})"
        return frame

    @classmethod
    def polygon(cls, corners: Sequence[Point], holes: Sequence[Sequence[Point]] = ()) -> Frame:
        """Return a polygon, with polygonal holes if given.

        Parameters
        ----------
        corners : sequence of (x, y)
            At least three corners in order (length); the contour closes by itself.
        holes : sequence of sequences of (x, y)
            Contours of the holes.

        Raises
        ------
        ValueError
            If the contour crosses itself or encloses no area.
        """
        load_modules("shapely.geometry")
        from shapely.geometry import Polygon

        rings = [[_point(corner, f"corners[{i}]") for i, corner in enumerate(corners)]]
        rings += [[_point(corner, f"holes[{k}][{i}]") for i, corner in enumerate(hole)] for k, hole in enumerate(holes)]
        for ring, argument in zip(rings, ["corners", *(f"holes[{k}]" for k in range(len(holes)))], strict=True):
            if len(ring) < 3:
                raise ValueError(f"a polygon needs at least 3 corners, got {len(ring)}: {ring}")
            if _on_one_line(ring):
                ends = f"from {min(ring)} to {max(ring)}"
                raise ValueError(f"{argument} must enclose an area, but all {len(ring)} lie on one line, {ends}")
        name = f"polygon({len(rings[0])} corners" + (f", {len(holes)} holes)" if holes else ")")
        width, height = (max(places) - min(places) for places in zip(*rings[0], strict=True))
        _refuse_extremes(width, height, name)
        frame = cls.from_shapely(Polygon(rings[0], rings[1:]))
        frame._name = name
        return frame

    @classmethod
    def from_shapely(cls, geometry: BaseGeometry | Any) -> Frame:
        """Wrap a shapely Polygon or MultiPolygon, a closed ring, a collection of these, or what tells such a geometry.

        Parameters
        ----------
        geometry : shapely geometry, or object with ``__geo_interface__``
            Polygons of a collection are joined.

        Raises
        ------
        TypeError
            If the geometry is not of that kind.
        ValueError
            If it is empty or invalid (the message carries shapely's reason).
        """
        load_modules("shapely")
        import shapely

        geometry = polygons_of(geometry)
        kind = getattr(geometry, "geom_type", type(geometry).__name__)
        if kind not in ("Polygon", "MultiPolygon"):
            raise TypeError(f"geometry must be a shapely Polygon or MultiPolygon, got {kind}")
        if not shapely.is_valid(geometry):
            raise ValueError(f"the contour is not a valid polygon: {shapely.is_valid_reason(geometry)}")
        if geometry.is_empty or geometry.area == 0:
            raise ValueError("the contour encloses no area")

        return cls(geometry, _polygon_predicate(geometry), f"from_shapely({kind})")

    def in_crs(self, crs: str | int) -> Frame:
        """Return the frame with its coordinates said to be those of a coordinate reference system.

        Nothing is transformed; the lattices and models that are made from the frame know it, and so do their files.

        Parameters
        ----------
        crs : str or int
            As ``"EPSG:25832"``, as WKT, or an EPSG code; its axes must be metres, or another length, and not degrees.

        Examples
        --------
        >>> import contactqp as cq
        >>> field = cq.Frame.rectangle(200, 100, center=(450_100, 5_500_050)).in_crs(25832)
        >>> field.lattice(10.0).crs
        'EPSG:25832'
        """
        frame = copy(self)
        frame.crs = checked_crs(crs)
        return frame

    def _crs_with(self, other: Frame) -> str:
        if self.crs and other.crs and self.crs != other.crs:
            raise ValueError(f"{self!r} is in {self.crs}, and {other!r} in {other.crs}; bring both into one system")
        return self.crs or other.crs

    @classmethod
    def from_wkt(cls, text: str) -> Frame:
        """Return the polygon, with holes and in several parts if need be, that well-known text describes.

        Parameters
        ----------
        text : str
            ``"POLYGON ((...))"``, ``"MULTIPOLYGON (...)"``; ``"SRID=25832;POLYGON ..."`` tells the coordinate reference
            system as well.

        Raises
        ------
        ValueError
            If it is no such text, or no valid polygon.

        Examples
        --------
        >>> import contactqp as cq
        >>> frame = cq.Frame.from_wkt("SRID=25832; POLYGON ((0 0, 4 0, 4 3, 0 3, 0 0), (1 1, 2 1, 2 2, 1 2, 1 1))")
        >>> frame.area, frame.crs
        (11.0, 'EPSG:25832')
        """
        load_modules("shapely")
        import shapely

        head, _, rest = text.partition(";")
        told = head.strip().upper().startswith("SRID=") and rest
        try:
            geometry = shapely.from_wkt((rest if told else text).strip())
        except shapely.errors.ShapelyError as error:
            raise ValueError(f"the contour is no well-known text: {error}") from None
        return cls.from_shapely(geometry).in_crs(f"EPSG:{head.partition('=')[2].strip()}" if told else "")

    @classmethod
    def from_geojson(cls, source: str | Path | Mapping[str, Any]) -> Frame:
        """Return the polygons of a GeoJSON geometry, feature or collection of features, joined.

        Parameters
        ----------
        source : path, str or mapping
            A file (``.geojson`` or ``.json``), the text itself, or what `json.loads` makes of it. Coordinates are taken
            as they are, as lengths; a member ``crs``, which the older specification has, tells their system.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        TypeError, ValueError
            If it is no GeoJSON of polygons; the message tells the file.

        Examples
        --------
        >>> import contactqp as cq
        >>> square = {"type": "Polygon", "coordinates": [[[0, 0], [2, 0], [2, 2], [0, 2], [0, 0]]]}
        >>> cq.Frame.from_geojson({"type": "Feature", "geometry": square, "properties": {}}).area
        4.0
        """
        name, data = read_geojson(source)
        try:
            return cls.from_shapely(polygons_in(data)).in_crs(crs_in(data))
        except (TypeError, ValueError) as error:
            raise type(error)(f"{name}{error}") from None

    @property
    def area(self) -> float:
        """Enclosed area (length squared)."""
        return float(self.geometry.area)

    @cached_property
    def sides(self) -> Sides:
        """The straight sides of the contour."""
        return Sides(self.geometry)

    def lattice(self, spacing: float, origin: Point | None = None, *, fitted: bool = False) -> Lattice:
        """Lay a square lattice over the frame and keep the points strictly inside it.

        A point on the contour, to 1e-9 of the frame's extent, belongs to the frame. Beside the nodes the lattice's next
        points stand for the frame, so where the contour does not lie on the lattice the frame is a little too wide: by
        `Lattice.overshoot`, which its repr tells, and `Lattice.caution` beside every answer. A disk never fits; a
        polygon does whose sides lie along the axes or at 45°, if the spacing divides all of them.

        Parameters
        ----------
        spacing : float
            Distance of neighbouring points (length), > 0.
        origin : (float, float), optional
            A point of the lattice, inside the frame or not (length). By default (0, 0), or where that does not fit and
            the left lower corner of the frame's box does, that corner.
        fitted : bool
            Whether arms that the contour cuts end there, at θ times the spacing: they are as much stiffer as they are
            shorter, T/θ, which makes deflections exact to second order in the spacing, in the maximum norm (Gibou,
            Fedkiw, Cheng and Kang, *A second-order-accurate symmetric discretization of the Poisson equation on
            irregular domains*, J. Comput. Phys. 176, 2002). A node with θ < 0.001 belongs to the frame. Arms between
            two nodes are not cut: a slit or a spike of the frame that is narrower than the spacing is passed over, as
            without. Every node stands for the spacing squared, as everywhere.

        Returns
        -------
        Lattice
            Its array just covers the frame.

        Warns
        -----
        ContactWarning
            If the frame, or an arm of it between parallel sides, grows by more than a twentieth of its width:
            deflections grow by twice as much.

        Raises
        ------
        ValueError
            If no point of the lattice lies inside, the frame would be twice as wide as it is, all points lie next to
            the contour that arms end on, or there would be more points than are taken (see
            `contactqp.foundation.limits`): the message tells count and memory.

        Examples
        --------
        >>> import contactqp as cq
        >>> cq.Frame.rectangle(3, 2).lattice(1.0).node_x
        array([-0.5,  0.5])
        >>> cq.Frame.disk(1.0).lattice(0.25)
        Lattice(45 nodes in 9 x 9, spacing=0.25, up to 0.12 outside its contour)
        >>> cq.Frame.disk(1.0).lattice(0.25, fitted=True)
        Lattice(45 nodes in 9 x 9, spacing=0.25, fitted to its contour)
        """
        fit = self._fit(spacing, origin, ALONE, fitted=boolean(fitted, "fitted"))
        return fit.fitted_lattice(self.crs, self.outline(fit.spacing)) if fitted else fit.lattice(self.crs)

    def outline(self, spacing: float) -> Outline:
        """Return the contour as closed lines, by which a lattice that is fitted to it remembers it.

        Of circles the chords are a quarter of the spacing long at most. Where a circle meets the contour of a frame
        that it is joined with, or cut out of, its chords are taken for the contour itself.

        Parameters
        ----------
        spacing : float
            That of the lattice (length).

        Examples
        --------
        >>> import contactqp as cq
        >>> ring = (cq.Frame.disk(1.0) - cq.Frame.disk(0.5)).outline(spacing=0.1)
        >>> len(ring.rings), bool(0 < ring.sagitta < 0.1 / 100)
        (2, True)
        """
        return self._outline(spacing_of_nodes(spacing))

    def lattice_by_rows(self, spacing: float, origin: Point | None = None, together: Together = ALONE) -> LatticeByRows:
        """Lay a square lattice over the frame as `lattice` does, but row by row: nobody lays out the whole of it.

        Parameters
        ----------
        spacing, origin
            See `lattice`.
        together : Together
            The processes, each of which looks at some rows to find out how the lattice lies to the contour; all of them
            must call it, and learn the same.

        Raises
        ------
        ValueError
            See `lattice`, in every process.

        Examples
        --------
        >>> import contactqp as cq
        >>> lattice = cq.Frame.disk(1.0).lattice_by_rows(0.5)
        >>> lattice.shape, lattice[0:2].astype(int)
        ((5, 5), array([[0, 0, 0, 0, 0],
               [0, 1, 1, 1, 0]]))
        """
        return self._fit(spacing, origin, together, fitted=False).by_rows(self.crs)

    def _fit(self, spacing: float, origin: Point | None, together: Together, *, fitted: bool) -> FrameFit:
        """Return the lattice that fits best, through an origin if there is one."""
        spacing = spacing_of_nodes(spacing)
        if origin is not None:
            laid = self._laid(spacing, _point(origin, "origin"), together)
        else:
            laid = self._laid(spacing, (0.0, 0.0), together)
            corner = self._corner_that_fits(spacing)
            if corner != (0.0, 0.0) and (laid is None or laid.growth > 0):
                moved = self._laid(spacing, corner, together)
                laid = moved if moved is not None and (laid is None or moved.growth < laid.growth) else laid
        left, bottom, right, top = self.geometry.bounds
        if laid is None or (laid.growth >= 1 and not fitted):
            inside = "no lattice point" if laid is None else "next to no lattice point"
            raise ValueError(
                f"{inside} of spacing {spacing:g} lies inside {self!r}; "
                f"choose a spacing well below {min(right - left, top - bottom):g}"
            )
        return laid

    def _corner_that_fits(self, spacing: float) -> Point:
        """Return an origin by which the frame's box lies on the lattice, in each direction where there is one."""
        left, bottom, right, top = self.geometry.bounds
        wide, high = (
            is_whole(left / spacing) or is_whole(right / spacing),
            is_whole(bottom / spacing) or is_whole(top / spacing),
        )
        return (
            left if is_whole((right - left) / spacing) and not wide else 0.0,
            bottom if is_whole((top - bottom) / spacing) and not high else 0.0,
        )

    def _laid(self, spacing: float, origin: Point, together: Together) -> FrameFit | None:
        """Return the points inside the frame of the lattice through a point; None if there are none."""
        left, bottom, right, top = self.geometry.bounds
        coordinates = np.abs([left, bottom, right, top, *origin])
        margin = max(_RELATIVE_TOLERANCE * max(right - left, top - bottom), 8 * float(np.spacing(coordinates.max())))
        each = f" in each of {together.size} processes" if together.size > 1 else ""
        refuse_too_many(
            ((right - left) / spacing + 1) * ((top - bottom) / spacing + 1) / together.size,
            f"lattice points of spacing {spacing:g} over {self!r}{each}",
            BYTES_TO_SOLVE,
            "choose a larger spacing",
        )
        for axis, low, high, start in (("x", left, right, origin[0]), ("y", bottom, top, origin[1])):
            refuse_indistinct(min(low, start), max(high, start), spacing, axis)
        columns = _covering(left, right, origin[0], spacing)
        rows = _covering(bottom, top, origin[1], spacing)
        x, y = origin[0] + spacing * columns, origin[1] + spacing * rows
        fit = FrameFit(x, y, spacing, self.geometry.bounds, self.sides, self._inside, margin, together)
        return fit if fit.held.rows.any() else None

    def plot(self, ax: Any = None, *, title: str | None = None, units: UnitNames = "") -> Figure:
        """Draw the frame: the contour and what it encloses.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes of your own to draw into; by default there is a new figure, which shows itself in a notebook.
        title : str, optional
            Headline in place of the picture's own.
        units : str, optional
            Unit of length for labels.
        """
        figure: Figure = drawn(self, Wanted(ax, None, title, units))
        return figure

    def __or__(self, other: Frame) -> Frame:
        joined = _closed(self.geometry.union(other.geometry))
        in_joined = _polygon_predicate(joined)

        def inside(x: _Grid, y: _Grid, margin: float) -> Mask:
            # The joined polygon adds the points of edges that both share, which are inside neither.
            return np.asarray(self._inside(x, y, margin) | other._inside(x, y, margin) | in_joined(x, y, margin))

        return self._combined(other, joined, inside, "|", lambda one, two: _closed(one.union(two)))

    def __and__(self, other: Frame) -> Frame:
        def inside(x: _Grid, y: _Grid, margin: float) -> Mask:
            return np.asarray(self._inside(x, y, margin) & other._inside(x, y, margin))

        geometry = self.geometry.intersection(other.geometry)
        _refuse_empty(geometry, f"{self!r} & {other!r}")
        return self._combined(other, geometry, inside, "&", lambda one, two: one.intersection(two))

    def __sub__(self, other: Frame) -> Frame:
        def inside(x: _Grid, y: _Grid, margin: float) -> Mask:
            return np.asarray(self._inside(x, y, margin) & ~other._inside(x, y, -margin))

        geometry = self.geometry.difference(other.geometry)
        _refuse_empty(geometry, f"{self!r} - {other!r}")
        return self._combined(other, geometry, inside, "-", lambda one, two: one.difference(two))

    def _combined(self, other: Frame, geometry: BaseGeometry, inside: _Inside, sign: str, combine: _Combine) -> Frame:
        frame = Frame(geometry, inside, f"{self._name} {sign} {other._name}").in_crs(self._crs_with(other))
        frame._outline = lambda spacing: self._outline(spacing).combined(other._outline(spacing), combine)
        return frame

    def __repr__(self) -> str:
        return f"Frame.{self._name}"


def _closed(geometry: BaseGeometry) -> BaseGeometry:
    """Close slits that are no wider than rounding, as between edges that were computed separately."""
    left, bottom, right, top = geometry.bounds
    extent, largest = max(right - left, top - bottom), float(np.abs(geometry.bounds).max())
    width = max(_RELATIVE_TOLERANCE * extent, 8 * float(np.spacing(largest)))
    return geometry.buffer(width, join_style="mitre").buffer(-width, join_style="mitre")


def _polygon_predicate(geometry: BaseGeometry) -> _Inside:
    """Return the test for points strictly inside a polygon, made about its own corner to keep digits far from 0."""
    load_modules("shapely")
    import shapely

    corner_x, corner_y = geometry.bounds[:2]
    local = shapely.transform(geometry, lambda points: points - np.array([corner_x, corner_y]))

    shapely.prepare(local)

    @lru_cache(maxsize=_CONTOURS_KEPT)
    def shrunk(margin: float) -> BaseGeometry:
        moved = local.buffer(-margin, join_style="mitre")
        shapely.prepare(moved)
        return moved

    def inside(x: _Grid, y: _Grid, margin: float) -> Mask:
        contour = shrunk(margin) if margin else local
        return np.asarray(shapely.contains_xy(contour, x - corner_x, y - corner_y))

    return inside


def _point(value: Any, name: str) -> Point:
    if np.shape(value) != (2,):
        raise ValueError(f"{name} must be a pair (x, y), got {value!r}")
    return finite_number(value[0], f"{name}[0]"), finite_number(value[1], f"{name}[1]")


def _covering(low: float, high: float, origin: float, spacing: float) -> NDArray[np.float64]:
    """Return the whole numbers k for which origin + k spacing just covers [low, high]."""
    slack = 1e-6
    first = math.floor((low - origin) / spacing + slack)
    last = math.ceil((high - origin) / spacing - slack)
    return np.arange(first, last + 1, dtype=np.float64)


_LEAST_EXTENT, _LARGEST_EXTENT = 1e-130, 1e130
"""Beyond, areas are no normal numbers in double precision; shapely's own checks do not see that."""


def _refuse_extremes(width: float, height: float, name: str) -> None:
    if not all(_LEAST_EXTENT < extent < _LARGEST_EXTENT for extent in (width, height)):
        raise ValueError(
            f"a frame must be between {_LEAST_EXTENT:g} and {_LARGEST_EXTENT:g} wide and high, "
            f"got {width:g} by {height:g} for {name}; choose another unit of length, or a place nearer to 0"
        )


def _refuse_empty(geometry: BaseGeometry, expression: str) -> None:
    if geometry.is_empty or geometry.area == 0:
        raise ValueError(f"{expression} encloses no area")


def _on_one_line(ring: Sequence[Point]) -> bool:
    """Whether all corners lie on one line, to rounding."""
    with np.errstate(over="ignore", invalid="ignore"):
        places = np.asarray(ring) - ring[0]
    size = np.abs(places).max()
    if not 0 < size < np.inf:
        return bool(size == 0)
    places /= size
    farthest = places[np.hypot(*places.T).argmax()]
    return bool(np.abs(places @ np.array([-farthest[1], farthest[0]])).max() <= 1e-12)
