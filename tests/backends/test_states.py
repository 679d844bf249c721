"""What library backends keep from load to load: the same answers, with less work."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import bounds, enumerate_solution, m_matrices

import contactqp as cq
from contactqp.backends import get_backend
from contactqp.backends.base import Stop, Task

LIBRARIES = ("osqp", "clarabel", "mangasarian")
HEXAGON = cq.gallery.paper_hexagon()
UP_AND_DOWN = (0.005, 0.02, 0.05, 0.1, 0.06, 0.03, 0.01)


def counted(monkeypatch, owner, name):
    """Return a list that grows by one at every call of an attribute."""
    calls, original = [], getattr(owner, name)
    monkeypatch.setattr(owner, name, lambda *a, **k: calls.append((a, k)) or original(*a, **k))
    return calls


def task_of(problem, scaled_units, tol=1e-8, **options):
    """Return a task whose judge knows the exact answer of a small problem."""
    exact = enumerate_solution(problem)

    def bound(gap):
        return float(np.abs(scaled_units.gap(gap) - exact).max() / problem.gap_scale)

    return Task(tol, None, None, options.pop("warm_start", None), bound, **options)


@pytest.mark.parametrize("name", LIBRARIES)
@pytest.mark.parametrize("warm_start", [True, False])
def test_loads_up_and_down_have_the_answers_of_cold_solves(name, warm_start):
    tol = 1e-8 if name != "mangasarian" else 1e-6
    solver = cq.Solver(HEXAGON, name, tol=tol)
    for load in UP_AND_DOWN:
        kept = solver.solve(load=load, warm_start=warm_start)
        cold = cq.solve(cq.gallery.paper_hexagon(load), name, tol=tol)
        assert kept.status == "certified"
        np.testing.assert_allclose(kept.gap, cold.gap, atol=2 * tol * kept.problem.gap_scale)


@pytest.mark.parametrize("name", ["osqp", "clarabel"])
@given(data=st.data())
def test_forces_and_bounds_change_between_solves(name, data):
    """One matrix and kinds of bounds, three times other numbers: equal bounds come apart, wide ones close up."""
    matrix = data.draw(m_matrices(max_size=6))
    size = len(matrix)
    lower, upper = data.draw(bounds(size))
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    state = start = None
    for _ in range(3):
        problem = cq.ContactQP(matrix, rng.normal(size=size) * np.sqrt(np.diag(matrix)), lower, upper)
        scaled, units = problem.scaled()
        exact = enumerate_solution(problem)
        task = task_of(problem, units, warm_start=start)
        if state is None:
            state = get_backend(name).prepare(scaled, task)
        answer = state.solve(scaled.q, task, scaled)
        assert answer.stop is Stop.DONE
        np.testing.assert_allclose(units.gap(answer.gap), exact, atol=1.01e-8 * problem.gap_scale + 1e-12)
        start = answer.gap if rng.uniform() < 0.5 else None
        middle = rng.normal(size=size)
        width = rng.choice([0.0, 1e-9, 1.0], size)
        lower = np.where(np.isfinite(lower), middle - width, lower)
        upper = np.where(np.isfinite(upper), middle + width, upper)


@pytest.mark.parametrize("name", LIBRARIES)
def test_forces_alone_are_enough_to_ask_a_state(name):
    matrix = np.array([[2.0, -1.0], [-1.0, 2.0]])
    first = cq.ContactQP(matrix, [-1.0, 3.0], gap_scale=1.0)
    scaled, units = first.scaled()
    state = get_backend(name).prepare(scaled, task_of(first, units))
    for q in ([-1.0, 3.0], [-2.0, -3.0], [4.0, -1.0]):
        problem = cq.ContactQP(matrix, q, gap_scale=1.0)
        answer = state.solve(np.array(q) / units.force, task_of(problem, units))
        np.testing.assert_allclose(units.gap(answer.gap), enumerate_solution(problem), atol=1e-7)


def test_osqp_is_set_up_once_and_warm_starts_save_iterations(monkeypatch):
    import osqp

    setups = counted(monkeypatch, osqp.OSQP, "setup")
    solver = cq.Solver(HEXAGON, "osqp")
    loads = np.linspace(0.01, 0.1, 7)
    kept = [solver.solve(load=load) for load in loads]
    assert len(setups) == 1
    assert kept[0].setup_seconds > 0
    assert [solution.setup_seconds for solution in kept[1:]] == [0.0] * 6
    cold = [cq.solve(cq.gallery.paper_hexagon(load), "osqp") for load in loads]
    assert sum(solution.iterations for solution in kept) < 0.75 * sum(solution.iterations for solution in cold)


def test_osqp_polishes_at_every_load():
    """What OSQP says of its last polish is no word of this one."""
    solver = cq.Solver(HEXAGON, "osqp")
    for load in UP_AND_DOWN:
        solution = solver.solve(load=load)
        assert solution.relative_bound < 1e-10
        assert solution.findings == ()


def test_without_a_warm_start_osqp_begins_at_zero(monkeypatch):
    import osqp

    solver = cq.Solver(HEXAGON, "osqp")
    solver.solve(load=0.02)
    starts = counted(monkeypatch, osqp.OSQP, "warm_start")
    solver.solve(load=0.03, warm_start=False)
    ((_, given),) = starts
    assert not given["x"].any()
    assert not given["y"].any()


def test_nothing_is_printed_where_contact_comes_and_goes(capfd):
    solver = cq.Solver(cq.gallery.bowl(15), "osqp")
    contact = [solver.solve(load=load).contact.sum() for load in (8.0, 4.0, 2.0, 1.7, 1.4, 1.0, 0.2, 1.4, 2.0, 0.5)]
    assert min(contact) == 0 < max(contact)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("warm_start", [True, False])
def test_a_session_with_osqps_own_defaults_calls_it_as_it_is_shipped_at_every_load(monkeypatch, warm_start):
    import osqp

    solver = cq.Solver(HEXAGON, "osqp", tol="default")
    calls = counted(monkeypatch, osqp.OSQP, "solve")
    for load in (0.05, 0.02, 0.1):
        solution = solver.solve(load=load, on_failure="ignore", warm_start=warm_start)
        assert solution.note == "OSQP as shipped: eps 0.001, rho 0.1, at most 4000 iterations"
        assert solution.termination == "solved, eps 1e-03"
        assert solution.iterations % 25 == 0
    assert len(calls) == 3


def test_from_the_second_load_on_osqp_polishes_before_the_judge_is_asked():
    asked, state, start = [], None, None
    for load in (0.06, 0.065):
        problem = cq.gallery.paper_hexagon(load).problem
        scaled, units = problem.scaled()

        def bound(gap, problem=problem, units=units):
            asked.append(gap)
            return cq.certify(problem, units.gap(gap)).gap_bound / problem.gap_scale

        asked.clear()
        task = Task(1e-6, None, None, None if start is None else units.dimensionless(start), bound)
        state = state or get_backend("osqp").prepare(scaled, task)
        answer = state.solve(scaled.q, task, scaled)
        start, rounds = units.gap(answer.gap), len(asked)
    assert rounds == 1
    assert answer.gap is asked[0]
    assert answer.iterations < 50
    assert bound(answer.gap) < 1e-10


def test_the_rounds_of_a_resumed_solve_keep_the_iteration_limit():
    solver = cq.Solver(HEXAGON, "osqp", max_iter=250)
    assert solver.solve(load=0.1).status == "certified"
    cut = solver.solve(load=0.001, on_failure="ignore")
    assert (cut.status, cut.claimed_solved) == ("iteration_limit", False)
    assert cut.iterations == 250


@pytest.mark.parametrize("trouble", [KeyboardInterrupt, ZeroDivisionError])
def test_a_workspace_that_was_interrupted_is_not_used_again(monkeypatch, trouble):
    import osqp

    setups = counted(monkeypatch, osqp.OSQP, "setup")
    solver = cq.Solver(HEXAGON, "osqp")
    solver.solve(load=0.05)

    def interrupted(*_, **__):
        raise trouble

    with monkeypatch.context() as patch:
        patch.setattr(osqp.OSQP, "solve", interrupted)
        with pytest.raises(trouble):
            solver.solve(load=0.04)
    assert len(setups) == 1
    assert solver.solve(load=0.03).status == "certified"
    assert len(setups) == 2


def test_a_workspace_that_failed_is_not_used_again(monkeypatch):
    import osqp

    setups = counted(monkeypatch, osqp.OSQP, "setup")
    solver, original = cq.Solver(HEXAGON, "osqp"), osqp.OSQP.solve

    def failing(self, raise_error):
        result = original(self, raise_error=raise_error)
        result.info.status = "problem non convex"
        return result

    with monkeypatch.context() as patch:
        patch.setattr(osqp.OSQP, "solve", failing)
        failed = solver.solve(load=0.04, on_failure="ignore")
    assert (failed.status, failed.termination, failed.finite) == ("failed", "problem non convex, eps 1e-04", False)
    assert solver.solve(load=0.03).status == "certified"
    assert len(setups) == 2


def test_clarabel_analyses_its_matrices_once(monkeypatch):
    import clarabel

    solvers = counted(monkeypatch, clarabel, "DefaultSolver")
    solver = cq.Solver(HEXAGON, "clarabel")
    for load in UP_AND_DOWN:
        assert solver.solve(load=load).status == "certified"
    assert len(solvers) == 1


def test_clarabel_is_made_anew_where_its_data_must_not_be_changed(monkeypatch):
    """Bounds beyond what Clarabel calls infinite are taken out of its data, which then allows no update."""
    import clarabel

    solvers = counted(monkeypatch, clarabel, "DefaultSolver")
    problem = cq.ContactQP(np.eye(2), [-1.0, -2.0], 0.0, [1e30, 1.0], gap_scale=1.0)
    solver = cq.Solver(problem, "clarabel")
    for q in ([-1.0, -2.0], [-3.0, 1.0]):
        np.testing.assert_allclose(solver.solve(q=q).gap, np.clip(-np.array(q), 0.0, [np.inf, 1.0]), atol=1e-6)
    assert len(solvers) == 2


@pytest.mark.parametrize("status", ["NumericalError", "InsufficientProgress", "DualInfeasible"])
def test_a_solver_of_clarabel_that_broke_down_is_not_used_again(monkeypatch, status):
    import clarabel

    made, broken = [], []

    class Result:
        def __init__(self, result):
            self.x, self.z, self.iterations, self.status = result.x, result.z, result.iterations, status

    class Breaking:
        def __init__(self, *arguments):
            made.append(self)
            self._own = original(*arguments)

        def __getattr__(self, name):
            return getattr(self._own, name)

        def solve(self):
            return Result(self._own.solve()) if self in broken else self._own.solve()

    original = clarabel.DefaultSolver
    monkeypatch.setattr(clarabel, "DefaultSolver", Breaking)
    solver = cq.Solver(HEXAGON, "clarabel")
    solver.solve(load=0.05)
    broken.extend(made)
    assert solver.solve(load=0.04).status == "certified"
    assert solver.solve(load=0.03).termination.startswith("Solved")
    assert len(made) == 2


def test_a_round_of_clarabel_that_is_cut_short_is_followed_by_the_next(monkeypatch):
    from contactqp.backends import clarabel

    monkeypatch.setattr(clarabel._Prepared, "most_iterations", 3)
    solution = cq.solve(HEXAGON, "clarabel", on_failure="ignore")
    assert (solution.status, solution.iterations, solution.claimed_solved) == ("inaccurate", 9, False)
    limited = cq.solve(HEXAGON, "clarabel", max_iter=5, on_failure="ignore")
    assert (limited.status, limited.iterations) == ("iteration_limit", 5)


def test_every_solve_of_a_state_has_its_own_clock():
    solver = cq.Solver(HEXAGON, "osqp", time_limit=30.0)
    assert [solver.solve(load=load).status.value for load in (0.02, 0.03)] == ["certified"] * 2
    scaled, _ = HEXAGON.problem.scaled()
    late = Task(1e-8, None, 5.0, None, lambda gap: 1.0, started=-1e6)
    for name in LIBRARIES:
        answer = get_backend(name).prepare(scaled, late).solve(scaled.q, late)
        assert (answer.gap, answer.stop, answer.termination) == (None, Stop.TIME_LIMIT, "time limit during set-up")


@pytest.mark.parametrize("name", LIBRARIES)
def test_options_are_read_from_prepare(name):
    backend = get_backend(name)
    assert "eps" in backend.options()
    with pytest.raises(TypeError, match=f"backend '{name}' has no option 'epsilon'; did you mean 'eps'"):
        cq.Solver(HEXAGON, name, epsilon=1e-9)


def test_active_sets_go_on_with_the_forces_that_multigrid_was_given(monkeypatch):
    from contactqp.backends import multigrid

    monkeypatch.setattr(multigrid.CycleLog, "outcome", lambda *_: (Stop.FAILED, "stalled"))
    problem, other = (cq.gallery.paper_hexagon(load).problem for load in (0.02, 0.03))
    scaled, _ = problem.scaled()
    task = Task(1e-9, None, None, None, lambda gap: 0.0)
    forces = other.q * (scaled.q[0] / problem.q[0])
    answer = get_backend("multigrid").prepare(scaled, task).solve(forces, task)
    exact = cq.solve(scaled.with_forces(forces), "active-set", tol=1e-9)
    np.testing.assert_allclose(answer.gap, exact.gap, atol=1e-9)
