"""AreaModel: nodes of a lattice in plan, a membrane's or a plate's, over a rigid support."""

from __future__ import annotations

from .on_lattice import LatticeModel


class AreaModel(LatticeModel):
    """Nodes in plan, which stand for an area each.

    Base of `Membrane` and `Plate`, beside the one that says by what their nodes resist.
    """

    _load_unit = "force per area"
    _pressure_unit = "force per area"
    _tension_unit = "force per length"
    _foundation_unit = "force per area and length"
