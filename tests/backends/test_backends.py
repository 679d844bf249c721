import subprocess
import sys
from importlib import metadata

import numpy as np
import pytest
from ctrl_c import PROMPTLY, seconds_to_answer
from strategies import BACKENDS

import contactqp as cq
from contactqp import backends
from contactqp.backends.base import Answer, Backend, Need, Stop

PROBLEM = cq.gallery.islands()


class Forger(Backend):
    """Claims success, and returns what it likes."""

    name, summary, package = "forger", "returns zeros", "numpy"

    def solve(self, problem, task, *, value: float = 0.0):
        return Answer(np.full(problem.size, value), Stop.DONE, "optimal, honestly", 1, 0.0, 0.0)


class Crasher(Forger):
    name = "crasher"

    def solve(self, problem, task):
        raise ZeroDivisionError("somewhere deep inside")


class Quitter(Forger):
    name = "quitter"

    def solve(self, problem, task):
        return Answer(None, Stop.FAILED, "gave up", 0, 0.0, 0.0)


class Missing(Forger):
    name, package = "missing", "a-package-that-is-not-installed"


class Picky(Forger):
    name, needs = "picky", (Need.LATTICE,)


@pytest.fixture
def outsiders(monkeypatch):
    """Backends of another distribution, announced by entry points."""
    classes = {cls.name: cls for cls in (Forger, Crasher, Quitter, Missing, Picky)}

    class Entry(metadata.EntryPoint):
        def load(self):
            return classes[self.name]

    found = {name: Entry(name, f"elsewhere:{name}", backends.ENTRY_POINT_GROUP) for name in classes}
    monkeypatch.setattr(backends, "_outsiders", lambda: found)
    return classes


def test_names():
    assert cq.backend_names()[: len(BACKENDS)] == list(BACKENDS)
    for name in BACKENDS:
        backend = backends.get_backend(name)
        assert backend.name == name
        assert backend.version()
        assert backend.summary


def test_unknown_names_list_the_known_ones_and_the_nearest():
    with pytest.raises(
        cq.UnknownBackendError, match=r"unknown backend 'clarabelle'; did you mean 'clarabel'\?; known: auto, osqp, "
    ):
        cq.solve(PROBLEM, "clarabelle")
    with pytest.raises(TypeError, match="backend must be a name or a Backend, got 7"):
        cq.solve(PROBLEM, 7)


@pytest.mark.parametrize("name", BACKENDS)
def test_unknown_options_are_errors_that_list_the_known_ones(name):
    with pytest.raises(TypeError, match=f"backend '{name}' has no option 'no_such_thing'.*its options: "):
        cq.solve(PROBLEM, name, no_such_thing=1)


def test_a_mistyped_option_gets_a_suggestion():
    with pytest.raises(TypeError, match=r"no option 'relaxtion'; did you mean 'relaxation'\?"):
        cq.solve(PROBLEM, "psor", relaxtion=1.5)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"tol": 0.0}, ValueError, "tol must lie strictly between 0 and 1, got 0"),
        ({"tol": 1.0}, ValueError, "tol must lie strictly between 0 and 1, got 1"),
        ({"tol": np.nan}, ValueError, "tol must be finite, got nan"),
        ({"max_iter": 0}, ValueError, "max_iter must be >= 1, got 0"),
        ({"max_iter": 10.0}, TypeError, "max_iter must be an integer, got 10.0"),
        ({"time_limit": 0.0}, ValueError, "time_limit must be > 0, got 0"),
        ({"warm_start": np.zeros(3)}, ValueError, r"warm_start must have shape \(34,\), got \(3,\)"),
        ({"warm_start": np.full(34, np.nan)}, ValueError, "warm_start must be finite"),
        ({"on_failure": "explode"}, ValueError, "on_failure must be one of 'warn', 'raise', 'ignore', got 'explode'"),
    ],
)
@pytest.mark.parametrize("name", ["auto", "psor"])
def test_bad_arguments_say_what_is_wrong(arguments, error, message, name):
    with pytest.raises(error, match=message):
        cq.solve(PROBLEM, name, **arguments)


def test_what_is_no_problem_is_refused():
    with pytest.raises(
        TypeError, match="problem must be a Membrane, a Cable, a CableNet, a ContactQP or a ContactLCP, got ndarray"
    ):
        cq.solve(np.eye(2), "psor")


@pytest.mark.parametrize("name", BACKENDS)
def test_iteration_limits_are_kept_and_reported(name):
    model = cq.gallery.bowl(31)
    with pytest.warns(cq.ContactWarning, match=f"{name} stopped at its iteration limit: bound"):
        solution = cq.solve(model, name, max_iter=2)
    assert solution.status == cq.Status.ITERATION_LIMIT
    assert solution.iterations <= 2 or name == "mangasarian"
    assert "advice" in repr(solution)
    with pytest.raises(cq.NotCertifiedError) as caught:
        cq.solve(model, name, max_iter=2, on_failure="raise")
    assert caught.value.solution.status == cq.Status.ITERATION_LIMIT


@pytest.mark.parametrize("name", BACKENDS)
def test_time_limits_are_kept_and_reported(name):
    model = cq.gallery.bowl(100)
    solution = cq.solve(model, name, time_limit=1e-4, tol=1e-9, on_failure="ignore")
    assert solution.status == cq.Status.TIME_LIMIT
    # The clock is looked at after a step at the earliest.
    assert solution.iterations < max(2, cq.solve(model, name, tol=1e-9).iterations)


@pytest.mark.parametrize("name", ["osqp", "psor"])
def test_warm_starts_are_used(name):
    """From the solution of another backend both need fewer iterations than from zero."""
    model = cq.gallery.bowl(31)
    exact = cq.solve(model, "clarabel", tol=1e-9)
    cold = cq.solve(model, name)
    warm = cq.solve(model, name, warm_start=exact.gap)
    assert warm.iterations < cold.iterations
    assert warm.status == "certified"


def test_mangasarian_refuses_what_is_no_z_matrix():
    """min ω_1 + ω_2 over the feasible set of this problem is (0, ½); its solution is (1, 0)."""
    problem = cq.ContactQP(np.array([[1.0, 2.0], [2.0, 5.0]]), [-1.0, -1.0])
    with pytest.raises(cq.UnsuitableProblemError, match=r"needs a Z-matrix .* but G\[0, 1\] = 2; take 'osqp'"):
        cq.solve(problem, "mangasarian")
    for name in ("osqp", "clarabel", "psor", "auto"):
        solution = cq.solve(problem, name)
        assert solution.status.ok
        np.testing.assert_allclose(solution.gap, [1.0, 0.0], atol=1e-5)
        assert "(weaker bound, no M-matrix)" in repr(solution)


@pytest.mark.parametrize("cost", [None, np.linspace(0.1, 10.0, 34), np.full(34, 1e-9)])
def test_any_positive_cost_finds_the_least_element(cost):
    solution = cq.solve(PROBLEM, "mangasarian", cost=cost)
    np.testing.assert_allclose(solution.gap, cq.solve(PROBLEM, "clarabel").gap, atol=1e-6)


def test_bad_costs_say_what_is_wrong():
    with pytest.raises(ValueError, match="cost must be > 0 everywhere, but entry 0 is 0"):
        cq.solve(PROBLEM, "mangasarian", cost=np.zeros(34))
    with pytest.raises(ValueError, match=r"cost must have shape \(34,\)"):
        cq.solve(PROBLEM, "mangasarian", cost=[1.0])
    with pytest.raises(ValueError, match="method must be one of"):
        cq.solve(PROBLEM, "mangasarian", method="simplex")


def test_mangasarian_simplifies_where_highs_fails_without():
    """Without presolve HiGHS gives up at once on 40,000 unknowns; then it is asked again, up to the limits."""
    solution = cq.solve(cq.gallery.bowl(200), "mangasarian", time_limit=3.0, on_failure="ignore")
    assert solution.status in (cq.Status.TIME_LIMIT, cq.Status.CERTIFIED)


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("mangasarian", {"method": "highs-ipm"}),
        ("mangasarian", {"presolve": True}),
        ("mangasarian", {"presolve": False}),
        ("clarabel", {"direct_solve_method": "faer"}),
        ("osqp", {"polishing": False}),
        ("osqp", {"adaptive_rho": False, "rho": 0.1, "scaling": 0}),
    ],
)
def test_options_of_the_libraries_are_passed_on(name, options):
    assert cq.solve(cq.gallery.paper_hexagon(), name, **options).status == "certified"


def test_a_backends_claim_of_success_counts_for_nothing(outsiders):
    solution = cq.solve(cq.gallery.paper_hexagon(), "forger", on_failure="ignore")
    assert solution.status == cq.Status.INACCURATE
    assert "optimal, honestly" in repr(solution)
    assert cq.solve(cq.ContactQP(np.eye(2), [1.0, 2.0]), "forger").status == "certified"  # zero is right there


def test_outsiders_are_found_by_entry_point_and_judged_alike(outsiders):
    assert cq.backend_names()[len(BACKENDS) :] == list(outsiders)
    assert type(backends.get_backend("forger")) is Forger
    with pytest.raises(cq.MissingBackendError, match="type: pip install a-package-that-is-not-installed"):
        cq.solve(PROBLEM, "missing")
    with pytest.raises(cq.UnsuitableProblemError, match="needs a problem on a lattice"):
        cq.solve(cq.ContactQP(np.eye(2), [1.0, 1.0]), "picky")
    failed = cq.solve(PROBLEM, "quitter", on_failure="ignore")
    assert failed.status == cq.Status.FAILED
    assert np.isnan(failed.gap).all()
    assert "gave up" in repr(failed)
    with pytest.raises(ZeroDivisionError):
        cq.solve(PROBLEM, "crasher")


def test_a_comparison_turns_every_failure_into_a_row(outsiders):
    comparison = cq.compare(PROBLEM, ["clarabel", "forger", "crasher", "quitter", "missing", "psor"])
    status = comparison.to_frame()["status"].to_dict()
    assert status == {
        "clarabel": "certified", "forger": "inaccurate", "crasher": "error", "quitter": "failed", "missing": "missing",
        "psor": "certified",
    }  # fmt: skip
    assert not comparison.agree
    assert set(comparison.culprits) == {"forger", "crasher", "quitter", "missing"}
    assert "ZeroDivisionError: somewhere deep inside" in comparison.culprits["crasher"]
    assert "min reaction -" in comparison.culprits["forger"]
    assert "pip install" in comparison.culprits["missing"]
    text = repr(comparison)
    assert "No agreement: forger (inaccurate: bound" in text
    assert len({pair.first for pair in comparison.pairs} | {pair.second for pair in comparison.pairs}) == 3


@pytest.mark.parametrize("name", BACKENDS)
@pytest.mark.parametrize("load", cq.gallery.PAPER_LOADS)
def test_every_backend_certifies_down_to_its_reachable_tolerance(name, load):
    tol = backends.get_backend(name).reachable_tol
    assert cq.solve(cq.gallery.paper_hexagon(load), name, tol=tol).status == "certified"


@pytest.mark.parametrize("name", BACKENDS)
def test_what_double_precision_cannot_certify_ends_soon_and_says_so(name):
    solution = cq.solve(cq.gallery.paper_hexagon(), name, tol=1e-17, on_failure="ignore")
    assert solution.status == cq.Status.INACCURATE
    assert solution.relative_bound < 1e-9
    assert solution.iterations < 20_000


@pytest.mark.parametrize("name", BACKENDS)
def test_nothing_is_printed(name, capfd):
    square = cq.Frame.rectangle(10, 10).lattice(1.0)
    checkered = cq.Membrane(square, 1.0, load=100 * (-1.0) ** (square.node_x + square.node_y), support=1e4)
    cq.solve(checkered, name, on_failure="ignore")
    for model in (cq.ContactQP([[2.0]], [-1.0]), cq.ContactQP([[2.0]], [1.0]), PROBLEM, cq.gallery.paper_hexagon()):
        if name in backends.suitable_backends(getattr(model, "problem", model)):
            cq.solve(model, name, tol=1e-7)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("options", [{"alpha": 3.0}, {"rho": -1.0}, {"check_termination": 0}])
def test_bad_osqp_options_say_what_is_wrong(options):
    with pytest.raises(ValueError, match=f"{next(iter(options))} must"):
        cq.solve(PROBLEM, "osqp", **options)


def test_auto_says_why():
    small, lattice = cq.solve(PROBLEM), cq.solve(cq.gallery.bowl(127))
    assert (small.backend, lattice.backend) == ("active-set", "multigrid")
    assert "few" in small.note
    assert "note        auto: a lattice with 16129 nodes" in repr(lattice)
    matrix = cq.solve(cq.ContactQP(cq.gallery.bowl(79).problem.G, cq.gallery.bowl(79).problem.q))
    assert (matrix.backend, matrix.note) == ("active-set", "auto: an M-matrix with 6241 unknowns")
    other = cq.solve(cq.ContactQP([[1.0, 0.5], [0.5, 1.0]], [-1.0, 1.0]))
    assert (other.backend, other.note) == ("active-set", "auto: 2 unknowns are few")


def test_importing_loads_no_solver_and_nothing_heavy():
    solvers = ["osqp", "clarabel", "highspy", "cvxpy", "qpsolvers", "scipy"]
    heavy = [*solvers, "numba", "matplotlib", "pandas", "xarray", "shapely", "rich", "typer", "pydantic"]
    code = f"import contactqp, sys; print([name for name in {heavy} if name in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["psor", "clarabel", "osqp", "mangasarian"])
def test_ctrl_c_ends_a_long_solve_within_a_second(name):
    """The child interrupts itself while it solves, and reports how long the answer took."""
    nodes = {"psor": 1200, "clarabel": 350, "osqp": 200, "mangasarian": 200}[name]
    assert seconds_to_answer(name, nodes, 1e-10) < PROMPTLY


def test_a_family_that_is_misspelt_is_recognised():
    with pytest.raises(cq.UnknownBackendError, match=r"unknown backend 'qpsolver:piqp'; did you mean 'qpsolvers:piqp'"):
        backends.get_backend("qpsolver:piqp")
