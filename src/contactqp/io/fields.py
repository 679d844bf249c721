"""The quantities of an answer at the nodes, with units and meanings: what every file format writes."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..foundation.checks import Mask, Vector
from ..models.records import states_of

if TYPE_CHECKING:
    from ..models.base import ContactModel
    from ..models.records import Answered, Enclosed


_ONE_SIDED = "1 certainly in contact, 0 certainly clear, -1 undecided"
_TWO_SIDED = "1 certainly in contact with the support, 2 with the upper bound, 0 certainly clear, -1 undecided"


class Field(NamedTuple):
    """A quantity at the nodes.

    Attributes
    ----------
    values : array, shape (n,)
        Numbers, or a yes or no for each node.
    unit : str
        In words: length, force, force per area; 1 for a pure number, and for yes and no.
    meaning : str
        What it is, in a few words.
    """

    values: Vector | Mask
    unit: str
    meaning: str


def fields_of(solution: Answered) -> dict[str, Field]:
    """Return every quantity of an answer at the nodes, by name.

    Parameters
    ----------
    solution : Solution

    Returns
    -------
    dict of str to Field
        gap, reaction and contact; of a model also deflection, support, load, what it has of ceiling, foundation and of
        a tension that varies (tension, or tension_x and tension_y), of a beam bending_moment and shear, and, where its
        nodes stand for an area, contact_pressure; with a certificate also gap_lower, gap_upper, reaction_lower,
        reaction_upper and contact_state (see `NodeState`). Where a model has no support, gap and its bounds are
        infinite.

    Examples
    --------
    >>> import contactqp as cq
    >>> fields = fields_of(cq.solve(cq.gallery.paper_hexagon()))
    >>> fields["contact_pressure"].unit
    'force per area'
    >>> fields["reaction"].meaning
    'nodal reaction of the support, upwards'
    """
    problem, model, certificate = solution.problem, solution.model, solution.certificate
    gap, *bounds = [solution.gap] if certificate is None else [solution.gap, certificate.lower, certificate.upper]
    if model is not None:
        gap, *bounds = (model.clearance(each) for each in (gap, *bounds))
    clearance = Field(gap, "length", "clearance over the support")
    holding = "the support" if problem.one_sided else "both bounds"
    reaction = Field(solution.reaction, "force", f"nodal reaction of {holding}, upwards")
    if model is None:
        fields = {"gap": clearance, "reaction": reaction}
    else:
        shape, forces = _shape(solution, model), _forces(solution, model)
        fields = {"gap": clearance, **shape, "reaction": reaction, **forces}
    told = "whether the node touches, by the backend's own answer: this, not reaction > 0, tells where there is contact"
    fields["contact"] = Field(solution.contact, "1", told)
    if certificate is not None:
        fields |= _certified(certificate, *bounds)
        states = _ONE_SIDED if problem.one_sided else _TWO_SIDED
        fields["contact_state"] = Field(states_of(certificate).astype(np.float64), "1", states)
    return fields


def _shape(solution: Answered, model: ContactModel) -> dict[str, Field]:
    return {
        "deflection": Field(solution.deflection, "length", f"deflection, {model.sense}"),
        "support": Field(model.support, "length", f"height of the rigid profile, {model.sense}"),
        **{name: Field(*facts) for name, facts in model.fields.items()},
        **{name: Field(*facts) for name, facts in model.fields_of_answer(solution.gap).items()},
    }


def _forces(solution: Answered, model: ContactModel) -> dict[str, Field]:
    fields = {"load": Field(model.load, model.units["load"], "active load, positive downwards")}
    if model.node_area is not None:
        unit = model.units["contact_pressure"]
        holding = "the support" if solution.problem.one_sided else "both bounds"
        fields["contact_pressure"] = Field(
            solution.contact_pressure, unit, f"reaction of {holding}, upwards; 0 where clear"
        )
    return fields


def _certified(certificate: Enclosed, lower: Vector, upper: Vector) -> dict[str, Field]:
    return {
        "gap_lower": Field(lower, "length", "certified lower bound of the gap"),
        "gap_upper": Field(upper, "length", "certified upper bound of the gap"),
        "reaction_lower": Field(certificate.reaction[0], "force", "certified lower bound of the reaction"),
        "reaction_upper": Field(certificate.reaction[1], "force", "certified upper bound of the reaction"),
    }
