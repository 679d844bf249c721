"""Membrane: stretched over a plane frame, in the vicinity of a rigid profile."""

from __future__ import annotations

from typing import ClassVar

from ..foundation.keywords import by_name_after, known_by_name
from ..foundation.pictures import UnitNames
from ..foundation.units import checked_units, plain
from ..geometry.fields import FieldLike, Rows, checked_rows
from ..geometry.lattice import Lattice
from .on_area import AreaModel
from .stretched import StretchedModel
from .tension import Tension, TensionLike


class Membrane(AreaModel, StretchedModel):
    r"""A membrane over a smooth, rigid support.

    Small slopes, no friction: -T∇²w = p - ρ, w ≤ f, ρ ≥ 0, ρ(f - w) = 0, and w given on the frame; eqs. (2.1)-(2.5)
    of the paper that contactqp starts from. Five-point differences give R = Gω + q with nodal forces R = ρΔ²,
    P = pΔ² and q = P + b - Gf, eqs. (2.6)-(2.9).

    A tension that varies, or is not the same in both directions, a ceiling and an elastic foundation make it
    -∂x(T_x ∂x w) - ∂y(T_y ∂y w) + kw = p - ρ, c ≤ w ≤ f, with ρ ≤ 0 where the ceiling c holds. G stays an M-matrix.

    Parameters
    ----------
    lattice : Lattice
        The nodes.
    tension : number, array, xarray.DataArray or function of (x, y), or a pair of these
        T, force per length, > 0; of a pair (a tuple) the first along x, as of warp, the second along y. Of a function
        an arm between two nodes has the value in its middle, else the harmonic mean of the values at its ends, which is
        exact where the tension jumps midway. An array has the lattice's shape, frame included, or that with a ring of
        frame points about it, or is a vector in node order; where no value is given on the frame, or nan, an arm that
        ends there has that of its node.
    load : number, array, xarray.DataArray or function of (x, y)
        Active pressure p, positive downwards, force per area. An array is a vector in node order, or has the lattice's
        shape, frame included: rows are y, and the first is that of the smallest y unless ``rows`` says otherwise. A
        DataArray is placed by its coordinates.
    support : number, array, xarray.DataArray or function of (x, y)
        Height f of the rigid profile (length), given as the load is, or as a profile. Heights are positive downwards,
        unless ``upwards``; ``inf`` (``-inf``) where there is no support. A support far beyond the load's reach counts
        as none, see `unreachable`.
    frame_height : number, array or function of (x, y)
        Height of the frame, positive as those of the support, length.
    upwards : bool
        Whether heights are elevations, positive upwards: support and frame height as they are given, and the
        deflection and all pictures and files; ``-inf`` where there is no support. A load stays positive downwards, and
        a profile of `contactqp.profiles` a surface of depths.
    rows : {"up", "down"}
        Which way y goes from row to row of an array of the lattice's shape: ``"up"``, its first row is that of the
        smallest y; ``"down"``, of the largest, as in a picture. What comes out goes up in either case, so that with
        ``"down"`` an array without coordinates that is given later, such as an answer, must say its ``rows``.
    ceiling : number, array, xarray.DataArray or function of (x, y), optional
        Height c of a rigid surface above the membrane (length), given and positive as the support is: c ≤ f, or with
        ``upwards`` c ≥ f; ``-inf`` (``inf``) where there is none.
    foundation : number, array, xarray.DataArray or function of (x, y), optional
        Stiffness k ≥ 0 of an elastic foundation (Winkler), which pulls the membrane to height zero by kw: force per
        area and length.
        Load, support, ceiling, frame height and a tension that is one number may be given by `contactqp.between`; the
        model is then that of the middle, and `contactqp.solve_between` encloses all.
    units : str or mapping, optional
        Units of all numbers without one, as ``{"length": "m", "force": "kN"}``: free text, which labels and files tell.
        What has a unit of its own, a quantity of pint or an array whose ``attrs["units"]`` tells it, is then checked
        and converted, for which pint must know both.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind, shape or range, or the ceiling lies below the support; the message names it.

    Examples
    --------
    >>> import contactqp as cq
    >>> lattice = cq.Frame.rectangle(4, 4).lattice(spacing=1.0)
    >>> membrane = cq.Membrane(lattice, tension=1.0, load=1.0, support=0.9)
    >>> membrane
    Membrane(9 nodes, spacing=1, tension=1, load=1, support=0.9)
    >>> solution = cq.solve(membrane, backend="clarabel")
    >>> int(solution.contact.sum())
    1

    A fabric that is pulled harder along x, between a ceiling and a floor:

    >>> fabric = cq.Membrane(lattice, tension=(2.0, 1.0), load=[3.0] * 6 + [-3.0] * 3, support=0.5, ceiling=-0.25)
    >>> fabric
    Membrane(9 nodes, spacing=1, tension=(2, 1), load=-3 to 3, support=0.5, ceiling=-0.25)
    >>> cq.solve(fabric).contact_upper.nonzero()[0]
    array([6, 7, 8])
    """

    noun: ClassVar[str] = "membrane"

    @by_name_after(2, "load", "support", "frame_height")
    @known_by_name
    def __init__(
        self,
        lattice: Lattice,
        tension: TensionLike,
        *,
        load: FieldLike,
        support: FieldLike,
        frame_height: FieldLike = 0.0,
        upwards: bool = False,
        rows: Rows = "up",
        ceiling: FieldLike | None = None,
        foundation: FieldLike | None = None,
        units: UnitNames | None = None,
    ) -> None:
        made_from = {name: value for name, value in locals().items() if name not in ("self", "__class__")}
        names = checked_units(units)
        known = lattice if isinstance(lattice, Lattice) else None
        given = tension if isinstance(tension, tuple) else (tension,)
        given = tuple(plain(part, "tension", self._tension_unit, names) for part in given)
        tensions = Tension.of(known, given if isinstance(tension, tuple) else given[0], "xy", checked_rows(rows))
        super().__init__(
            *(lattice, tensions, load, support, frame_height),
            area=1.0 if known is None else known.spacing**2,
            arms=(tensions.fields[0].arms, tensions.fields[1].arms),
            upwards=upwards,
            rows=rows,
            ceiling=ceiling,
            foundation=foundation,
            units=names,
        )
        self._keep_arguments(made_from)
