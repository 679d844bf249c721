"""Models that differ in one parameter share what does not depend on it, and nothing that does."""

from functools import cached_property

import numpy as np
import pytest
from springs import springs

import contactqp as cq
from contactqp.models.varied import with_lift, with_load, with_load_of, with_support, with_tension

LATTICE = cq.Frame.rectangle(5, 4).lattice(1.0)


class Weighed(cq.Membrane):
    """A user's membrane, which remembers what it has derived from its data."""

    @cached_property
    def weight(self):
        return float(self.nodal_load.sum())

    @cached_property
    def deepest(self):
        return float(self.support.max())

    @cached_property
    def stiffest(self):
        return float(self.problem.G.max())


class WeighedTwice(Weighed):
    @cached_property
    def double(self):
        return 2 * self.weight


def weighed(load=1.5, tension=1.0, support=0.75):
    return WeighedTwice(LATTICE, tension, load=load, support=support)


@pytest.mark.parametrize(
    ("vary", "same"),
    [
        (lambda model: with_load(model, 2.0), weighed(load=3.0)),
        (lambda model: with_load_of(model, np.full(LATTICE.size, 3.0)), weighed(load=3.0)),
        (lambda model: with_tension(model, 2.0), weighed(tension=2.0)),
        (lambda model: with_lift(model, 0.25), weighed(support=0.5)),
        (lambda model: with_support(model, np.full(LATTICE.size, 0.5)), weighed(support=0.5)),
    ],
    ids=["load", "load at the nodes", "tension", "lift", "support"],
)
def test_what_a_subclass_remembers_is_derived_anew(vary, same):
    model = weighed()
    before = model.weight, model.deepest, model.stiffest, model.double
    varied = vary(model)
    assert type(varied) is WeighedTwice
    assert (varied.weight, varied.deepest, varied.stiffest, varied.double) == (
        same.weight,
        same.deepest,
        same.stiffest,
        same.double,
    )
    np.testing.assert_array_equal(varied.problem.q, same.problem.q)
    assert varied.problem.gap_scale == pytest.approx(same.problem.gap_scale, rel=1e-12)
    assert (model.weight, model.deepest, model.stiffest, model.double) == before


def test_other_forces_share_the_matrix():
    for model in (weighed(), springs()):
        base = model.problem
        for varied in (with_load(model, 2.0), with_lift(model, 0.1)):
            assert varied.problem.stiffness is base.stiffness
            assert varied.problem.q is not base.q
    tighter = with_tension(weighed(), 2.0)
    np.testing.assert_array_equal(tighter.problem.G.toarray(), 2 * weighed().problem.G.toarray())


def test_a_support_that_ends_elsewhere_makes_another_problem():
    model = weighed()
    support = np.where(np.arange(LATTICE.size) < 3, np.inf, 0.5)
    varied = with_support(model, support)
    assert model.problem.supported.all()
    np.testing.assert_array_equal(varied.problem.supported, np.isfinite(support))
    np.testing.assert_array_equal(varied.problem.q, weighed(support=support).problem.q)


@pytest.mark.parametrize("model", [springs(), cq.CableNet.orthogonal(LATTICE, 1.0, load=1.0, support=1.0)], ids=repr)
def test_a_tension_goes_with_lattices_only(model):
    with pytest.raises(TypeError, match="a tension can be given to a Membrane or a Cable only"):
        with_tension(model, 2.0)
