"""Scattered: a surface known at points that lie anywhere, such as soundings of a sea-bed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import Vector, one_of, read_only, real_array, refuse_non_finite, vector
from ..foundation.loading import load_modules
from .analytic import Profile
from .choices import DUPLICATES, KEEP_ONE, OUTSIDE, REACH, Decimal, Duplicates, Outside, one_of_each
from .sample_files import Column, read_points

Interpolation = Literal["linear", "nearest", "cubic"]
INTERPOLATIONS = ("linear", "nearest", "cubic")

_PULLS = (0.0, 1e-14, 1e-12, 1e-10, 1e-8)
"""By which parts of the way to the middle points on the hull are moved until they lie in a triangle."""


class Scattered(Profile):
    """A surface through soundings that lie anywhere in plan, within their convex hull.

    Parameters
    ----------
    x, y : array, shape (m,)
        Where the soundings lie, length.
    depth : array, shape (m,)
        Heights there, positive downwards, length.
    interpolation : {"linear", "nearest", "cubic"}
        Straight on the triangles of Delaunay, which reproduces planes; the depth of the nearest sounding; or the
        smooth piecewise cubic of Clough and Tocher on these triangles (Alfeld, Comput. Aided Geom. Des. 1, 1984),
        which may rise above the soundings between them.
    outside : {"error", "hold", "none"}
        Outside the soundings' hull: refuse, continue with the depth at the hull's nearest point, or no support.
    duplicates : {"error", "mean", "first", "last", "shallowest", "deepest"}
        Of several soundings at one place: refuse, or keep one.
    upwards : bool
        Whether the heights given are elevations, positive upwards; the profile itself returns depths all the same.

    Raises
    ------
    TypeError, ValueError
        If there are fewer than three places, all lie on a line, several are one, or an entry is not finite or not a
        number.

    Attributes
    ----------
    x, y, depth : array, shape (places,)
        The soundings, read-only; heights are positive downwards, whatever they were given as.

    Notes
    -----
    Bays of a survey's outline and holes in it lie within the hull and are bridged by long triangles.

    Examples
    --------
    >>> bed = Scattered([0.0, 4.0, 0.0, 4.0], [0.0, 0.0, 2.0, 2.0], [80.0, 82.0, 81.0, 83.0])
    >>> bed
    Scattered(4 soundings, x from 0 to 4, y from 0 to 2, linear)
    >>> bed([1.0, 2.0], 1.0).round(12)
    array([81. , 81.5])
    >>> bed(5.0, 1.0)
    Traceback (most recent call last):
    ...
    ValueError: x = 5, y = 1 lies outside the soundings' hull, ...; pass outside='hold' ... or outside='none' ...
    """

    def __init__(
        self,
        x: ArrayLike,
        y: ArrayLike,
        depth: ArrayLike,
        *,
        interpolation: Interpolation = "linear",
        outside: Outside = "error",
        duplicates: Duplicates = "error",
        upwards: bool = False,
    ) -> None:
        abscissae = real_array(x, "x")
        if abscissae.ndim != 1:
            raise ValueError(f"x must have one dimension, got shape {abscissae.shape}")
        refuse_non_finite(abscissae, "x")
        ordinates, depths = vector(y, abscissae.size, "y"), vector(depth, abscissae.size, "depth")
        self.interpolation = one_of(interpolation, INTERPOLATIONS, "interpolation")
        self.outside = one_of(outside, OUTSIDE, "outside")
        one_of(duplicates, DUPLICATES, "duplicates")
        kept = _one_at_each_place(abscissae, ordinates, -depths if upwards else depths, duplicates)
        self.x, self.y, self.depth = map(read_only, kept)
        self._set_up()

    @classmethod
    def from_file(
        cls,
        path: str | Path,
        x: Column | None = None,
        y: Column | None = None,
        depth: Column | None = None,
        *,
        delimiter: str | None = None,
        decimal: Decimal = ".",
        interpolation: Interpolation = "linear",
        outside: Outside = "error",
        duplicates: Duplicates = "error",
        upwards: bool = False,
    ) -> Scattered:
        r"""Read the soundings from a text file with x, y and a depth in each line, as .xyz and .csv files have them.

        Empty lines and lines that begin with # are passed over. The first row left is the header if a column is chosen
        by name, or if none of its cells is a number.

        Parameters
        ----------
        path : path
            A text file in UTF-8.
        x, y, depth : str or int, optional
            The columns, by name or by position, which counts from 0; by default those called x and y and the only
            other one, and without a header the first three.
        delimiter : str, optional
            What separates the columns: by default a semicolon, a tabulator, a comma or blanks, whichever of these the
            first row has.
        decimal : {".", ","}
            What begins the decimals of a number.
        interpolation, outside, duplicates, upwards
            See the class.

        Raises
        ------
        OSError
            If the file cannot be read.
        ValueError
            If a column is missing, a cell is not a finite number, or the soundings are no surface; the message names
            the file, and the line where there is one.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> file = pathlib.Path(tempfile.mkdtemp()) / "bed.xyz"
        >>> _ = file.write_text("# soundings\n0 0 80\n4 0 82\n0 2 81\n")
        >>> Scattered.from_file(file)
        Scattered(3 soundings, x from 0 to 4, y from 0 to 2, linear)
        """
        found = read_points(Path(path), x, y, depth, delimiter=delimiter, decimal=decimal)
        given: dict[str, Any] = {"interpolation": interpolation, "outside": outside, "duplicates": duplicates}
        try:
            return cls(*found.values.T, **given, upwards=upwards)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None

    def _set_up(self) -> None:
        load_modules("scipy.interpolate", "scipy.spatial")
        from scipy.spatial import ConvexHull, Delaunay, QhullError

        if self.x.size < 3:
            raise ValueError(f"a surface needs soundings at three places or more, got {self.x.size}")
        low, high = (np.array([part(self.x), part(self.y)]) for part in (np.min, np.max))
        self._middle, self._scale = low / 2 + high / 2, float((high - low).max()) / 2
        places = self._scaled(self.x, self.y)
        across = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
        on_a_line = ValueError(
            f"the {self.x.size} soundings lie on a line, which makes no surface; profiles.Sampled takes the ground "
            "along a line"
        )
        if across[1] <= REACH * across[0]:
            raise on_a_line
        try:
            triangles, hull = Delaunay(places), ConvexHull(places)
        except QhullError:
            raise on_a_line from None
        self._sides: Vector = hull.equations
        self._corners: Vector = places[hull.vertices]
        # Gradients are estimated to a tolerance in absolute terms, so that depths should be about 1.
        self._datum, spread = float(self.depth.min()), float(np.ptp(self.depth))
        self._spread = spread or 1.0
        self._between = _interpolator(self.interpolation, places, triangles, (self.depth - self._datum) / self._spread)

    def __call__(self, x: ArrayLike, y: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Return the depths f at the points (x, y)."""
        along, across = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))
        refuse_non_finite(along, "x")
        refuse_non_finite(across, "y")
        points = self._scaled(along.ravel(), across.ravel())
        beyond = self._beyond(points)
        if self.outside == "error" and beyond.any():
            k = int(np.argmax(beyond))
            raise ValueError(
                f"x = {along.flat[k]:g}, y = {across.flat[k]:g} lies outside the soundings' hull, "
                f"{self._extent}; pass outside='hold' to continue with the depth at the hull, or outside='none' for no "
                "support there"
            )
        depth = np.full(len(points), np.inf)
        if self.outside == "none":
            depth[~beyond] = self._within(points[~beyond])
        else:
            points[beyond] = self._on_hull(points[beyond])
            depth = self._within(points)
        return np.asarray(depth.reshape(along.shape))

    def _scaled(self, x: Vector, y: Vector) -> Vector:
        """Return points in plan with the soundings between -1 and 1, which keeps their triangles."""
        return np.asarray((np.column_stack([x, y]) - self._middle) / self._scale)

    def _beyond(self, points: Vector) -> NDArray[np.bool_]:
        beyond = np.zeros(len(points), dtype=np.bool_)
        for *normal, offset in self._sides:
            beyond |= points @ np.array(normal) + offset > REACH
        return beyond

    def _on_hull(self, points: Vector) -> Vector:
        """Return the points of the hull that are nearest to points outside."""
        nearest, least = points.copy(), np.full(len(points), np.inf)
        for first, second in zip(self._corners, np.roll(self._corners, -1, axis=0), strict=True):
            side = second - first
            share = np.clip((points - first) @ side / (side @ side), 0.0, 1.0)
            foot = first + share[:, None] * side
            distance = np.hypot(*(points - foot).T)
            nearer = distance < least
            nearest[nearer], least[nearer] = foot[nearer], distance[nearer]
        return nearest

    def _within(self, points: Vector) -> Vector:
        """Return the depths at points of the hull, shape (m,); those on its edge may lie outside by rounding."""
        found, middle = np.full(len(points), np.nan), self._corners.mean(axis=0)
        for pull in _PULLS:
            lost = np.isnan(found)
            if lost.any():
                found[lost] = self._between(points[lost] + pull * (middle - points[lost]))
        return np.asarray(self._datum + self._spread * found)

    @property
    def _extent(self) -> str:
        x, y = self.x, self.y
        return f"x from {x.min():g} to {x.max():g}, y from {y.min():g} to {y.max():g}"

    def __repr__(self) -> str:
        outside = "" if self.outside == "error" else f", outside={self.outside!r}"
        return f"Scattered({self.x.size} soundings, {self._extent}, {self.interpolation}{outside})"


def _interpolator(kind: str, places: Vector, triangles: Any, depth: Vector) -> Callable[[Vector], Vector]:
    from scipy.interpolate import CloughTocher2DInterpolator, LinearNDInterpolator, NearestNDInterpolator

    kinds: dict[str, Callable[[], Any]] = {
        "linear": lambda: LinearNDInterpolator(triangles, depth),
        "nearest": lambda: NearestNDInterpolator(places, depth),
        "cubic": lambda: CloughTocher2DInterpolator(triangles, depth, tol=1e-9, maxiter=2000),
    }
    found: Callable[[Vector], Vector] = kinds[kind]()
    return found


def _one_at_each_place(x: Vector, y: Vector, depth: Vector, kept: str) -> tuple[Vector, Vector, Vector]:
    """Return one sounding for each place, in the order given where there are no others."""
    order = np.lexsort((y, x))
    new = np.concatenate([[True], (np.diff(x[order]) != 0) | (np.diff(y[order]) != 0)])[: x.size]
    if new.all():
        return x, y, depth
    if kept == "error":
        k = order[int(np.argmin(new))]
        raise ValueError(
            f"two soundings or more at x = {x[k]:g}, y = {y[k]:g}, and at {(~new).sum() - 1} other places: {KEEP_ONE}"
            if (~new).sum() > 1
            else f"two soundings at x = {x[k]:g}, y = {y[k]:g}: {KEEP_ONE}"
        )
    starts = np.flatnonzero(new)
    return x[order][starts], y[order][starts], one_of_each(depth[order], starts, kept)
