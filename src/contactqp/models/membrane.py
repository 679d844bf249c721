"""Membrane: stretched over a plane frame, in the vicinity of a rigid profile."""

from __future__ import annotations

from ..foundation.checks import positive_number
from ..foundation.keywords import by_name_after, known_by_name
from ..foundation.pictures import UnitNames
from ..foundation.units import checked_units, plain
from ..geometry.fields import FieldLike, Rows
from ..geometry.lattice import Lattice
from .on_lattice import LatticeModel


class Membrane(LatticeModel):
    r"""A membrane of constant tension over a smooth, rigid support.

    Small slopes, no friction: -T∇²w = p - ρ, w ≤ f, ρ ≥ 0, ρ(f - w) = 0, and w given on the frame; eqs. (2.1)-(2.5)
    of the paper that contactqp starts from. Five-point differences give R = Gω + q with nodal forces R = ρΔ²,
    P = pΔ² and q = P + b - Gf, eqs. (2.6)-(2.9).

    Parameters
    ----------
    lattice : Lattice
        The nodes.
    tension : float
        T, force per length, > 0.
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
    units : str or mapping, optional
        Units of all numbers without one, as ``{"length": "m", "force": "kN"}``. What has a unit of its own, a quantity
        of pint or an array whose ``attrs["units"]`` tells it, is then checked and converted; files tell the units.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind, shape or range; the message names it.

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
    """

    _load_unit = "force per area"
    _pressure_unit = "force per area"

    @by_name_after(2, "load", "support", "frame_height")
    @known_by_name
    def __init__(
        self,
        lattice: Lattice,
        tension: float,
        *,
        load: FieldLike,
        support: FieldLike,
        frame_height: FieldLike = 0.0,
        upwards: bool = False,
        rows: Rows = "up",
        units: UnitNames | None = None,
    ) -> None:
        names = checked_units(units)
        tension = positive_number(plain(tension, "tension", "force per length", names), "tension")
        spacing = lattice.spacing if isinstance(lattice, Lattice) else 1.0
        super().__init__(
            *(lattice, tension, load, support, frame_height),
            area=spacing**2,
            arms=(tension, tension),
            upwards=upwards,
            rows=rows,
            units=names,
        )
