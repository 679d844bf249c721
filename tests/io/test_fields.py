"""What is written of an answer at the nodes."""

import numpy as np
import pytest
from ceilings import models_under_ceilings
from springs import Springs, springs

import contactqp as cq
from contactqp.io.fields import Field, fields_of
from contactqp.models.records import NodeState

MODELS = [cq.gallery.islands(), cq.gallery.cable_on_posts([1.0, 2.0], bay=4)[0], springs(), *models_under_ceilings()]


@pytest.mark.parametrize("model", MODELS, ids=lambda model: type(model).__name__)
def test_every_quantity_has_a_value_at_each_node_a_unit_and_a_meaning(model):
    solution = cq.solve(model)
    fields = fields_of(solution)
    for field in fields.values():
        assert isinstance(field, Field)
        assert field.values.shape == (model.size,)
        assert field.unit in {"length", "force", "force per length", "force per area", "1"}
        assert field.meaning
    for name in ("deflection", "reaction"):
        np.testing.assert_array_equal(fields[name].values, getattr(solution, name))
    for name in ("support", "load"):
        np.testing.assert_array_equal(fields[name].values, getattr(model, name))
    np.testing.assert_array_equal(fields["gap"].values, np.where(model.supported, solution.gap, np.inf))
    assert ("contact_pressure" in fields) == (model.node_area is not None)
    data = solution.to_dataset()
    assert list(data.data_vars)[: len(fields)] == list(fields)  # and then what the model is made of
    for name, field in fields.items():
        assert data[name].attrs == {"units": field.unit, "long_name": field.meaning}
        laid_out = data[name].values[~np.isnan(data["load"].values)]
        np.testing.assert_array_equal(laid_out, field.values)
        assert laid_out.dtype == field.values.dtype


@pytest.mark.parametrize("model", MODELS, ids=lambda model: type(model).__name__)
def test_contact_is_a_yes_or_no_and_pressure_is_nothing_where_it_is_certainly_clear(model):
    solution = cq.solve(model, "psor", tol=1e-3)  # free nodes are left out of balance
    data = solution.to_dataset()
    clear = solution.certificate.clear
    assert clear.any()
    assert np.any(solution.reaction[clear] > 0) or isinstance(model, Springs)  # which resist their own nodes alone
    assert data["contact"].dtype == bool
    assert int(data["contact"].sum()) == np.count_nonzero(solution.contact)
    if model.node_area is not None:
        assert (solution.contact_pressure[clear] == 0).all()
        np.testing.assert_array_equal(
            solution.contact_pressure, np.where(clear, 0, solution.reaction / model.node_area)
        )


def test_a_bare_problem_has_gap_reaction_and_their_bounds():
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0], lower=[-np.inf, 0.0])
    solution = cq.solve(problem)
    fields = fields_of(solution)
    assert list(fields)[:2] == ["gap", "reaction"]
    np.testing.assert_array_equal(fields["gap"].values, solution.gap)
    np.testing.assert_array_equal(fields["gap_upper"].values, solution.certificate.upper)
    assert "deflection" not in fields
    assert fields["contact_state"].values.tolist() == [0.0, 1.0]


def test_the_states_of_nodes_as_numbers():
    one_sided = fields_of(cq.solve(cq.gallery.islands()))["contact_state"]
    assert one_sided.meaning == "1 certainly in contact, 0 certainly clear, -1 undecided"
    for model in models_under_ceilings():
        solution = cq.solve(model)
        field = fields_of(solution)["contact_state"]
        assert field.meaning == (
            "1 certainly in contact with the support, 2 with the upper bound, 0 certainly clear, -1 undecided"
        )
        np.testing.assert_array_equal(field.values == NodeState.CONTACT, solution.contact_lower)
        np.testing.assert_array_equal(field.values == NodeState.CONTACT_UPPER, solution.contact_upper)
        assert set(field.values) == {0.0, 1.0, 2.0}
    undecided = cq.solve(cq.Membrane(cq.Frame.rectangle(3, 3).lattice(1.0), 1.0, load=0.0, support=0.0))
    assert (fields_of(undecided)["contact_state"].values == NodeState.UNDECIDED).all()
