"""Models under ceilings and on foundations: what they ask for, mirrored answers, and what must not change anything."""

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import enumerate_solution, lattice_masks

import contactqp as cq

LATTICE = cq.Frame.rectangle(4.0, 3.0).lattice(0.5)


def pushed(x, y):
    return np.where(x < 0, 1.0, -1.0) + 0.1 * y


def drawn(kind, seed, mask, *, upwards=False, flipped=False, **more):
    """Return a model with random data; ``flipped`` turns its columns round."""
    rng = np.random.default_rng(seed)
    size = int(mask.sum())
    support, gap = rng.uniform(0.05, 0.3, size), rng.uniform(0.1, 0.5, size)
    data = {
        "load": rng.normal(size=size),
        "support": support,
        "ceiling": support - gap,
        "foundation": rng.uniform(0, 2, size),
    }
    data = {name: values for name, values in data.items() if more.get(name, 0) is not None}
    data |= {name: value for name, value in more.items() if value is not None and name != "frame_height"}
    if upwards:
        data |= {name: -np.asarray(data[name]) for name in ("support", "ceiling") if name in data}
    if kind == "cable":
        order = slice(None, None, -1) if flipped else slice(None)
        data = {name: values[order] if np.ndim(values) else values for name, values in data.items()}
        return cq.Cable(nodes=size, spacing=0.5, tension=1.5, upwards=upwards, **data)
    lattice = cq.Lattice.from_mask(mask, 0.5)
    grids = {name: lattice.scatter(values, fill=0.0) if np.ndim(values) else values for name, values in data.items()}
    if flipped:
        lattice = cq.Lattice.from_mask(mask[:, ::-1], 0.5)
        grids = {name: values[:, ::-1] if np.ndim(values) else values for name, values in grids.items()}
    grids = {name: lattice.gather(values) if np.ndim(values) else values for name, values in grids.items()}
    make = cq.Membrane if kind == "membrane" else cq.CableNet.orthogonal
    return make(lattice, 1.5, upwards=upwards, **grids)


masks = lattice_masks(4, 4)
seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(["membrane", "cable", "net"])


@pytest.fixture(autouse=True)
def _strange_data_are_wanted():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", cq.ContactWarning)
        yield


@given(kinds, seeds, lattice_masks(3, 2))
def test_the_answer_is_that_of_an_enumeration(kind, seed, mask):
    model = drawn(kind, seed, mask)
    solution = cq.solve(model, "active-set", tol=1e-10)
    exact = enumerate_solution(model.problem)
    np.testing.assert_allclose(solution.gap, exact, atol=1e-9)
    w = model.deflection(exact)
    assert (w <= model.support + 1e-9).all()
    assert (w >= model.ceiling - 1e-9).all()
    balance = model.force_balance(exact)
    assert min(balance.reaction, balance.ceiling) >= -1e-9
    assert abs(balance.imbalance) < 1e-9


@given(kinds, seeds, masks)
def test_elevations_are_the_same_problem_with_other_signs(kind, seed, mask):
    down, up = drawn(kind, seed, mask), drawn(kind, seed, mask, upwards=True)
    one, other = cq.solve(down), cq.solve(up)
    np.testing.assert_array_equal(down.problem.q, up.problem.q)
    np.testing.assert_array_equal(down.problem.upper, up.problem.upper)
    np.testing.assert_array_equal(one.gap, other.gap)
    np.testing.assert_array_equal(one.deflection, -other.deflection)
    assert one.force_balance == other.force_balance


@given(kinds, seeds, masks)
def test_a_model_that_is_turned_over_has_the_answer_turned_over(kind, seed, mask):
    """What is floor becomes ceiling, and the load changes its sign."""
    model = drawn(kind, seed, mask)
    more = {"load": -model.load, "support": -model.ceiling, "ceiling": -model.support}
    over = drawn(kind, seed, mask, **more)
    one, other = (cq.solve(each, "active-set", tol=1e-10) for each in (model, over))
    np.testing.assert_allclose(one.deflection, -other.deflection, atol=1e-9)
    below, above = one.force_balance, other.force_balance
    assert below.reaction == pytest.approx(above.ceiling, abs=1e-8)
    assert below.foundation == pytest.approx(-above.foundation, abs=1e-8)


@given(kinds, seeds, masks)
def test_a_reflected_model_has_the_reflected_answer(kind, seed, mask):
    mask = np.ones_like(mask) if kind == "cable" else mask
    model, mirror = drawn(kind, seed, mask), drawn(kind, seed, mask, flipped=True)
    one, other = (cq.solve(each, "active-set", tol=1e-10) for each in (model, mirror))
    if kind == "cable":
        there, back = one.deflection, other.deflection[::-1]
    else:
        lattice = cq.Lattice.from_mask(mask, 0.5)
        turned = cq.Lattice.from_mask(mask[:, ::-1], 0.5)
        there, back = lattice.scatter(one.deflection), turned.scatter(other.deflection)[:, ::-1]
    np.testing.assert_allclose(there, back, atol=1e-9)


@given(kinds, seeds, masks, st.sampled_from(["active-set", "multigrid", "psor"]))
def test_no_ceiling_and_no_foundation_are_none_to_the_bit(kind, seed, mask, backend):
    bare = drawn(kind, seed, mask, ceiling=None, foundation=None)
    if backend == "multigrid" and kind == "net":
        backend = "active-set"
    plain = cq.solve(bare, backend)
    for more in (
        {"ceiling": -np.inf, "foundation": None},
        {"ceiling": -1e30, "foundation": None},
        {"ceiling": None, "foundation": 0.0},
        {"ceiling": np.full(bare.size, -1e12), "foundation": np.zeros(bare.size)},
    ):
        model = drawn(kind, seed, mask, **more)
        solution = cq.solve(model, backend)
        assert model.problem.one_sided
        np.testing.assert_array_equal(plain.gap, solution.gap)
        np.testing.assert_array_equal(plain.certificate.lower, solution.certificate.lower)
        np.testing.assert_array_equal(plain.certificate.upper, solution.certificate.upper)
        assert plain.iterations == solution.iterations
        assert plain.force_balance == solution.force_balance
    assert "out of reach" in cq.solve(drawn(kind, seed, mask, ceiling=-1e30, foundation=None)).note


@pytest.mark.parametrize("kind", [cq.Membrane, cq.CableNet.orthogonal])
@pytest.mark.parametrize("upwards", [False, True])
def test_a_ceiling_below_the_support_is_refused(kind, upwards):
    sign = -1.0 if upwards else 1.0

    def ceiling(x, y):
        return sign * np.where((x == 0.5) & (y == 1.0), 0.4, -0.1)

    with pytest.raises(
        ValueError, match=r"at node 32 .*x=0.5, y=1\) the ceiling is at -?0.4 and the support at -?0.3 \(1 such"
    ):
        kind(LATTICE, 1.0, load=1.0, support=sign * 0.3, ceiling=ceiling, upwards=upwards)


@pytest.mark.parametrize(
    ("more", "wanted"),
    [
        ({"ceiling": np.inf}, r"ceiling must be finite or -inf \(no ceiling\), but is inf at node 0"),
        ({"ceiling": [1.0, 2.0]}, r"ceiling must be a number"),
        (
            {"ceiling": 0.3, "support": 0.2},
            r"must not lie below the support, but at node 0 .*0.3 .*0.2 .*positive downwards",
        ),
        ({"foundation": -1.0}, r"foundation must be >= 0, but is -1 at node 0 \(x=-1.5"),
        ({"foundation": np.inf}, r"foundation must be finite, but is inf at node 0"),
        ({"foundation": lambda x, y: np.where(x > 1, np.nan, 1.0)}, r"foundation must be finite, but is nan at node 6"),
    ],
)
def test_what_is_no_ceiling_and_no_foundation_is_refused(more, wanted):
    with pytest.raises(ValueError, match=wanted):
        cq.Membrane(LATTICE, 1.0, **{"load": 1.0, "support": 0.3} | more)


def test_a_ceiling_at_the_support_holds_every_node_where_it_is():
    membrane = cq.Membrane(LATTICE, 1.0, load=1.0, support=0.3, ceiling=0.3)
    solution = cq.solve(membrane)
    np.testing.assert_array_equal(solution.deflection, 0.3)
    assert abs(solution.force_balance.imbalance) < 1e-12


def test_a_ceiling_alone_holds_what_nothing_supports():
    model = cq.Membrane(LATTICE, 1.0, load=-1.0, support=np.inf, ceiling=-0.2)
    mirror = cq.Membrane(LATTICE, 1.0, load=1.0, support=0.2)
    one, other = cq.solve(model), cq.solve(mirror)
    np.testing.assert_allclose(one.deflection, -other.deflection, atol=1e-12)
    assert one.contact_upper.sum() == other.contact_lower.sum() > 0
    assert one.force_balance.ceiling == pytest.approx(other.force_balance.reaction)


def test_a_frame_that_is_not_at_height_zero_leaves_the_foundation_there():
    """A long cable between raised ends lies where its springs are at rest, w = p/k."""
    cable = cq.Cable(span=40.0, spacing=0.25, tension=1.0, load=2.0, support=np.inf, foundation=4.0, frame_height=3.0)
    for backend in ("active-set", "multigrid", "psor"):
        solution = cq.solve(cable, backend, tol=1e-9)
        assert solution.status == "certified"
        assert solution.deflection[80] == pytest.approx(0.5, abs=1e-6)
        assert solution.force_balance.foundation == pytest.approx(4.0 * 0.25 * solution.deflection.sum())


def test_reprs_cards_datasets_and_units_know_them():
    model = cq.Membrane(LATTICE, 1.0, load=pushed, support=0.2, ceiling=-0.1, foundation=lambda x, y: 2 + x)
    assert repr(model).endswith("support=0.2, ceiling=-0.1, foundation=0.5 to 3.5)")
    assert "force per area and length" in model._repr_html_()
    data = cq.solve(model).to_dataset()
    assert data["ceiling"].attrs == {"units": "length", "long_name": "height of the ceiling, positive downwards"}
    assert data["foundation"].attrs["units"] == "force per area and length"
    np.testing.assert_array_equal(data["foundation"].sel(x=1.0, y=0.0), 3.0)
    assert data["contact_state"].max() == 2
    net = cq.CableNet.orthogonal(LATTICE, 1.0, load=1.0, support=0.2, foundation=0.5)
    assert cq.solve(net).to_dataset()["foundation"].attrs["units"] == "force per length"
    assert "ceiling" not in cq.solve(net).to_dataset()


def test_supports_and_ceilings_out_of_reach_are_so_for_good():
    """However far a ceiling presses the membrane down, a support that it can reach then is one."""
    model = cq.Membrane(LATTICE, 1.0, load=0.0, support=0.5, ceiling=0.4)
    assert model.supported.all()
    assert (cq.solve(model).deflection >= 0.4 - 1e-9).all()
    lifted = cq.Membrane(LATTICE, 1.0, load=0.0, support=-0.4, ceiling=-0.5)
    assert lifted.under_ceiling.all()


def test_sessions_go_on_under_a_ceiling():
    model = cq.Membrane(LATTICE, 1.0, load=pushed, support=0.2, ceiling=-0.1, foundation=1.0)
    solver = cq.Solver(model, "multigrid")
    for change in ({"load": 2.0}, {"lift": 0.15}, {"tension": 2.0}, {"support": 0.05}, {}):
        solution = solver.solve(**change)
        assert solution.status == "certified"
        alone = {"load": change.get("load", pushed), "support": change.get("support", 0.2 - change.get("lift", 0.0))}
        again = cq.Membrane(LATTICE, change.get("tension", 1.0), **alone, ceiling=-0.1, foundation=1.0)
        np.testing.assert_allclose(solution.deflection, cq.solve(again).deflection, atol=1e-6)
    with pytest.raises(ValueError, match=r"ceiling must not lie below the support, but at node 0"):
        solver.solve(lift=0.4)
