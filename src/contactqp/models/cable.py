"""Cable: stretched between fixed ends, in the vicinity of rigid ground."""

from __future__ import annotations

from typing import Any, ClassVar

from ..foundation.keywords import known_by_name
from ..foundation.pictures import UnitNames
from ..foundation.units import checked_units, plain
from ..geometry.fields import of_x_and_y
from ..geometry.lattice import Lattice
from .on_line import LineModel, lattice_on_line
from .stretched import StretchedModel
from .tension import Tension


class Cable(LineModel, StretchedModel):
    r"""A cable over a smooth, rigid support.

    -T w″ = p - ρ between fixed ends; three-point differences give G = (T/Δ) tridiag(-1, 2, -1), P = pΔ, and the same
    complementarity problem as for a membrane. With a tension that varies, a ceiling and an elastic foundation it is
    -(T w′)′ + kw = p - ρ, c ≤ w ≤ f.

    Parameters
    ----------
    span : float, optional
        Distance of the ends (length), a whole multiple of the spacing. Give ``span`` or ``nodes``.
    nodes : int, optional
        Number of nodes between the ends: span = (nodes + 1) spacing.
    spacing : float
        Δ, distance of neighbouring nodes (length), > 0.
    tension : number, array or function of x
        T, force, > 0. Of a function an arm between two nodes has the value in its middle, else the harmonic mean of the
        values at its ends. An array has a value for each node, or for each node and both ends (without, the outer arms
        have those of their nodes).
    load : number, array or function of x
        Active load p, positive downwards, force per length. A function of (x, y) gets y = 0.
    support : number, array or function of x
        Height f of the ground (length). Heights are positive downwards, unless ``upwards``; ``inf`` where there is
        none. Ground far beyond the load's reach counts as none, see `unreachable`.
    frame_height : number or function of x
        Heights of the ends, positive as those of the ground, length.
    start : float
        Abscissa of the left end (length).
    upwards : bool
        Whether heights are elevations, positive upwards: those of ground and ends as they are given, and the deflection
        and all pictures and files; ``-inf`` where there is no ground. A load stays positive downwards, and a profile of
        `contactqp.profiles` a surface of depths.
    ceiling : number, array or function of x, optional
        Height c of a rigid surface above the cable (length), given and positive as the ground is: c ≤ f, or with
        ``upwards`` c ≥ f; ``-inf`` (``inf``) where there is none.
    foundation : number, array or function of x, optional
        Stiffness k ≥ 0 of an elastic foundation (Winkler), which pulls the cable to height zero by kw: force per length
        and length.
    units : str or mapping, optional
        As for `Membrane`.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind, shape or range, or the ceiling lies below the ground; the message names it.

    Attributes
    ----------
    start : float
        Abscissa of the left end (length).

    Examples
    --------
    >>> import contactqp as cq
    >>> cable = cq.Cable(span=10.0, spacing=1.0, tension=1.0, load=1.0, support=2.0)
    >>> cable
    Cable(9 nodes, spacing=1, tension=1, load=1, support=2)
    >>> cq.solve(cable, backend="clarabel").contact.nonzero()[0] + 1
    array([2, 3, 4, 5, 6, 7, 8])

    On springs that hold it up, it comes down to the ground farther from its ends:

    >>> sprung = cq.Cable(span=10.0, spacing=1.0, tension=1.0, load=1.0, support=2.0, foundation=0.4)
    >>> cq.solve(sprung).contact.nonzero()[0] + 1
    array([4, 5, 6])
    """

    noun: ClassVar[str] = "cable"

    @known_by_name
    def __init__(
        self,
        span: float | None = None,
        nodes: int | None = None,
        *,
        spacing: float,
        tension: Any,
        load: Any,
        support: Any,
        frame_height: Any = 0.0,
        start: float = 0.0,
        upwards: bool = False,
        ceiling: Any = None,
        foundation: Any = None,
        units: UnitNames | None = None,
    ) -> None:
        made_from = {name: value for name, value in locals().items() if name not in ("self", "__class__")}
        names = checked_units(units)
        span, spacing, start = (
            plain(value, name, "length", names)
            for value, name in ((span, "span"), (spacing, "spacing"), (start, "start"))
        )
        lattice = Cable.lattice_of(span, nodes, spacing=spacing, start=start)
        tensions = Tension.of(lattice, of_x_and_y(plain(tension, "tension", "force", names)), "x")
        self.start, self._stiffness_of_tension = float(start), 1 / lattice.spacing
        super().__init__(
            *(lattice, tensions, load, support, frame_height),
            area=lattice.spacing,
            arms=(tensions.fields[0].arms / lattice.spacing, 0.0),
            upwards=upwards,
            ceiling=ceiling,
            foundation=foundation,
            units=names,
        )
        self._keep_arguments(made_from)

    @staticmethod
    def lattice_of(
        span: float | None = None, nodes: int | None = None, *, spacing: float, start: float = 0.0
    ) -> Lattice:
        """Return the lattice of a cable's nodes, one row of them.

        Parameters
        ----------
        span, nodes, spacing, start
            See the class.

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong kind or range.

        Examples
        --------
        >>> import contactqp as cq
        >>> cq.Cable.lattice_of(10.0, spacing=2.5, start=-5.0).x
        array([-2.5,  0. ,  2.5])
        """
        return lattice_on_line(span, nodes, spacing, start, Cable.noun)
