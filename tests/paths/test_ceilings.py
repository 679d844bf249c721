"""Load paths under ceilings and on foundations: what theory promises, and what is a finding."""

from dataclasses import replace

import numpy as np
import pytest

import contactqp as cq

LATTICE = cq.Frame.rectangle(4.0, 3.0).lattice(0.25)


def hung(**more):
    """A membrane that a low ceiling presses down beside its frame, over a dented floor."""
    data = {
        "load": lambda x, y: 0.5 + 0.3 * np.sin(3 * x),
        "support": lambda x, y: 0.35 + 0.02 * x**2,
        "ceiling": lambda x, y: 0.02 + 0.01 * np.cos(2 * y),
    }
    return cq.Membrane(LATTICE, 1.0, **data | more)


@pytest.mark.parametrize("foundation", [None, 0.8])
def test_a_growing_load_leaves_the_ceiling_and_settles_on_the_floor(foundation):
    model = hung(foundation=foundation)
    path = cq.trace(model, loads=[0.0, 0.2, 0.5, 1.0, 2.0])
    assert path.promised
    assert path.findings == ()
    lower, upper = ([solution.contact_lower.sum(), solution.contact_upper.sum()] for solution in path.solutions[::4])
    assert lower[0] == 0 < upper[0]
    assert lower[1] > upper[1] == 0 or upper[1] > lower[1]
    held = np.array([[s.contact_lower, s.contact_upper] for s in path.solutions])
    assert not (held[:-1, 0] & ~held[1:, 0]).any()  # what lies on the floor stays there
    assert not (~held[:-1, 1] & held[1:, 1]).any()  # and nothing comes back to the ceiling
    assert held[0, 1].sum() > held[-1, 1].sum()
    backwards = replace(path, solutions=path.solutions[::-1])
    assert any("gap grows" in finding for finding in backwards.findings)


def test_touchdown_loads_are_those_of_the_floor():
    path = cq.trace(hung(), loads=[0.0, 0.5, 1.0, 2.0])
    touchdown = path.touchdown(width=0.2)
    known = np.isfinite(touchdown.contact)
    assert known.any()
    assert np.isfinite(touchdown.clear[known]).all()  # under the ceiling a node is not on the floor
    closed = known & np.isfinite(touchdown.clear)
    assert (touchdown.contact - touchdown.clear)[closed].max() <= 0.2
    with pytest.raises(ValueError, match=r"events follows contact with a support alone, but Membrane\(.*ceiling"):
        cq.events(hung(), 1.0)


def test_a_support_that_is_lifted_presses_on_the_ceiling():
    model = hung(load=0.2, support=0.6, ceiling=-0.05)
    path = cq.trace(model, lifts=[0.0, 0.3, 0.5, 0.6, 0.64])
    assert path.findings == ()
    upper = [int(solution.contact_upper.sum()) for solution in path.solutions]
    assert upper[0] == 0 <= upper[-1]
    with pytest.raises(ValueError, match="ceiling must not lie below the support, but at node 0"):
        cq.trace(model, lifts=[0.0, 0.7])
    shut = cq.trace(hung(load=-5.0, support=0.6, ceiling=-0.05), lifts=[0.0, 0.64])
    assert shut.findings == ()
    assert any("leave the ceiling" in finding for finding in _swapped(shut))


def _swapped(path):
    """Findings about a path that is told to have been lifted by so little that the last answer leaves the ceiling."""
    fallen = cq.solve(hung(load=0.2, support=0.6, ceiling=-0.05))
    return replace(path, solutions=(path.solutions[0], fallen)).findings


def test_of_tension_over_a_foundation_nothing_is_promised():
    model = hung(ceiling=None, foundation=lambda x, y: np.where(x > 0, 20.0, 0.0))
    path = cq.trace(model, tensions=[0.05, 0.5, 2.0])
    assert not path.promised
    assert all("the foundation resists whatever the tension is" in finding for finding in path.findings)
    assert cq.trace(hung(), tensions=[0.5, 2.0]).promised
    assert cq.trace(hung(), tensions=[0.5, 2.0]).findings == ()


def test_checkpoints_tell_ceilings_and_foundations_apart(tmp_path):
    file = tmp_path / "path.nc"
    one = cq.trace(hung(), loads=[0.5, 1.0], checkpoint=file)
    again = cq.trace(hung(), loads=[0.5, 1.0], checkpoint=file)
    assert "restored" in again.solutions[0].note
    np.testing.assert_array_equal(one.solutions[1].gap, again.solutions[1].gap)
    for other in (hung(ceiling=lambda x, y: 0.02 + 0.0101 * np.cos(2 * y)), hung(foundation=lambda x, y: 1e-9 * x**2)):
        with pytest.raises(ValueError, match="belongs to another model"):
            cq.trace(other, loads=[0.5, 1.0], checkpoint=file)


def test_films_show_both_surfaces(tmp_path):
    path = cq.trace(hung(), loads=[0.0, 1.0])
    path.animate(tmp_path / "film.gif")
    assert (tmp_path / "film.gif").stat().st_size > 1000
