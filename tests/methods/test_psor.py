import numpy as np
import pytest

import contactqp as cq
from contactqp.gallery import PAPER_LOADS, paper_hexagon
from contactqp.paper import FACTORS
from contactqp.paper.scan import scan


@pytest.mark.parametrize("k", range(10))
def test_the_automatic_factor_needs_few_sweeps_more_than_the_scanned_best(k):
    model = paper_hexagon(PAPER_LOADS[k])
    best = min(cq.solve(model, "psor", relaxation=beta).iterations for beta in FACTORS[6:])
    assert cq.solve(model, "psor").iterations <= 1.10 * best


@pytest.mark.parametrize(
    ("nodes", "factors"),
    [
        (63, np.arange(1.72, 1.83, 0.01)),
        (127, np.arange(1.85, 1.90, 0.005)),
        pytest.param(255, np.arange(1.924, 1.943, 0.003), marks=pytest.mark.slow),
    ],
)
def test_the_automatic_factor_needs_few_sweeps_more_than_the_best_on_large_nets(nodes, factors):
    """Factors are scanned about the best, which a scan from 1 to 2 has found."""
    model = cq.gallery.bowl(nodes)
    counts = [cq.solve(model, "psor", relaxation=float(beta)).iterations for beta in factors]
    assert 0 < np.argmin(counts) < len(counts) - 1
    assert cq.solve(model, "psor").iterations <= 1.10 * min(counts)


@pytest.mark.parametrize("rule", ["step", "residual"])
def test_the_automatic_factor_does_for_the_papers_rules_too(rule):
    """Here some twenty sweeps are all, of which the first few are done with a factor that knows nothing."""
    ratios = []
    for load in PAPER_LOADS:
        options = {"stopping": rule, "stopping_length": 1e-3, "on_failure": "ignore"}
        automatic = cq.solve(paper_hexagon(load), "psor", **options).iterations
        ratios.append(automatic / scan(paper_hexagon(load), rule).least)
    assert max(ratios) <= 1.15
    assert np.mean(ratios) <= 1.10


def test_the_energy_falls_with_every_sweep():
    """For 0 < β < 2 each node's step lowers ½ωᵀGω + qᵀω (Cryer 1971)."""
    model = paper_hexagon()
    gap = np.zeros(1857)
    energies = [model.problem.objective(gap)]
    for _ in range(20):
        gap = cq.solve(model, "psor", relaxation=1.7, max_iter=1, warm_start=gap, on_failure="ignore").gap
        energies.append(model.problem.objective(gap))
    assert (np.diff(energies) < 0).all()


def test_both_orders_reach_the_same_answer():
    model = cq.gallery.l_shape_with_hole()
    one, other = (cq.solve(model, "psor", order=order, tol=1e-9) for order in ("lexicographic", "red-black"))
    np.testing.assert_allclose(one.gap, other.gap, atol=2e-9 * model.problem.gap_scale)


def test_a_warm_start_saves_sweeps():
    model = paper_hexagon()
    cold = cq.solve(model, "psor")
    warm = cq.solve(paper_hexagon(0.0301), "psor", warm_start=cold)
    assert warm.iterations < cold.iterations
    again = cq.solve(model, "psor", warm_start=cold)
    assert again.iterations == 1


def test_history_records_every_sweep_in_the_users_units():
    metres = cq.gallery.bowl(15)
    solution = cq.solve(metres, "psor", history=True)
    assert {name: len(values) for name, values in solution.history.items()} == dict.fromkeys(
        ("step", "residual", "relaxation"), solution.iterations
    )
    assert solution.history["residual"][-1] == pytest.approx(solution.residuals.natural_residual, rel=1e-6)
    assert not cq.solve(metres, "psor").history


def test_the_step_rule_is_judged_like_every_other_answer():
    with pytest.warns(cq.ContactWarning, match=r"psor returned an inaccurate answer: bound .*step"):
        solution = cq.solve(paper_hexagon(), "psor", stopping="step", stopping_length=1e-3)
    assert solution.status == cq.Status.INACCURATE
    assert solution.termination.startswith("step 0.00")


def test_matrices_and_varying_arms_are_swept_row_by_row():
    model = cq.gallery.bowl(15)
    bare = cq.ContactQP(model.problem.G, model.problem.q, gap_scale=model.problem.gap_scale)
    options = {"relaxation": 1.6, "stopping": "step", "stopping_length": 1e-9}
    lattice, matrix = (cq.solve(problem, "psor", **options) for problem in (model, bare))
    assert lattice.iterations == matrix.iterations
    np.testing.assert_allclose(lattice.gap, matrix.gap, atol=1e-12)
    rng = np.random.default_rng(5)
    mask = np.ones((9, 9), dtype=bool)
    stencil = cq.Stencil(mask, rng.uniform(0.5, 2, (9, 10)), rng.uniform(0.5, 2, (10, 9)))
    problem = cq.ContactQP(stencil, rng.normal(size=81))
    assert cq.solve(problem, "psor").status == "certified"
    np.testing.assert_allclose(
        cq.solve(problem, "psor").gap, cq.solve(problem, "clarabel").gap, atol=3e-6 * problem.gap_scale
    )


def test_psor_also_solves_matrices_that_are_no_z_matrices():
    solution = cq.solve(cq.ContactQP(np.array([[1.0, 2.0], [2.0, 5.0]]), [-1.0, -1.0]), "psor")
    assert solution.status == "certified"
    np.testing.assert_allclose(solution.gap, [1, 0], atol=1e-5)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"relaxation": 0.0}, r"relaxation must lie strictly between 0 and 2, got 0"),
        ({"relaxation": 2}, r"relaxation must lie strictly between 0 and 2, got 2"),
        ({"order": "columns"}, r"order must be one of 'lexicographic', 'red-black', got 'columns'"),
        ({"stopping": "stap"}, r"got 'stap'; did you mean 'step'\?"),
        ({"stopping": "step", "stopping_length": -1.0}, r"stopping_length must be > 0, got -1"),
    ],
)
def test_bad_options_say_what_is_wrong(options, message):
    with pytest.raises(ValueError, match=message):
        cq.solve(cq.gallery.islands(), "psor", **options)
    with pytest.raises(ValueError, match="needs a Membrane or a Cable"):
        cq.solve(cq.ContactQP([[1.0]], [1.0]), "psor", order="red-black")
    with pytest.raises(ValueError, match="stopping_length goes with"):
        cq.solve(cq.gallery.islands(), "psor", stopping_length=1e-3)


@pytest.mark.parametrize("order", ["lexicographic", "red-black"])
def test_the_automatic_factor_survives_rounding_noise(order):
    """Steps at rounding level decay no more; read as slow convergence they would drive the factor to 2."""
    cable = cq.Cable(nodes=800, spacing=1.0, tension=1.0, load=1e-2, support=1e4)
    solution = cq.solve(cable, "psor", tol=1e-9, order=order, on_failure="ignore")
    assert solution.iterations < 20_000
    assert solution.relative_bound < 1e-7
    assert float(solution.termination.rsplit(" ", 1)[1]) < 1.9995


def test_the_automatic_factor_is_the_same_in_other_units():
    plain = cq.solve(cq.gallery.bowl(31), "psor").iterations
    problem = cq.gallery.bowl(31).problem
    for scale in (1e-12, 1e12):
        stencil = cq.gallery.bowl(31).stencil.scaled(scale)
        scaled = cq.ContactQP(stencil, problem.q * scale, gap_scale=problem.gap_scale)
        assert cq.solve(scaled, "psor").iterations == plain


@pytest.mark.filterwarnings("ignore:support stands above the frame")
@pytest.mark.parametrize("support", [-1.0, np.inf, 0.4])
@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (2, 1), (3, 50), (40, 1)])
def test_the_automatic_factor_on_small_nets(shape, support):
    """All nodes in contact (the support presses), none supported, and some in contact."""
    lattice = cq.Lattice.from_mask(np.ones(shape, dtype=bool), 1.0)
    model = cq.Membrane(lattice, 1.0, load=0.3, support=support)
    assert cq.solve(model, "psor", tol=1e-8).status == "certified"


def test_the_automatic_factor_leaves_iterations_within_their_limit():
    for limit in (1, 7, 60):
        solution = cq.solve(cq.gallery.bowl(63), "psor", max_iter=limit, on_failure="ignore", history=True)
        assert solution.iterations == limit
        assert len(solution.history["step"]) == limit
