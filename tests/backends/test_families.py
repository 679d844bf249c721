"""Solvers that other packages call by name: one tolerance, limits, settings, and who is left out and why."""

import gc
import subprocess
import sys
import textwrap
import threading
import time
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
import qpsolvers
from ctrl_c import PROMPTLY, seconds_to_answer

import contactqp as cq
from contactqp import backends
from contactqp.backends import base, families
from contactqp.backends.base import Need
from contactqp.backends.setting_names import check_setting_names
from contactqp.backends.solvers import SOLVERS, facts_of
from contactqp.testing import check_backend

HEXAGON = cq.gallery.paper_hexagon()
BOWL = cq.gallery.bowl(15)
INSTALLED = [name for name in backends.family_names() if backends.why_missing(name) is None]
TESTED = ["piqp", "proxqp", "highs", "scs", "daqp", "quadprog", "ecos", "cvxopt"]
"""What the test extra installs; ecos has no wheels for newer Pythons."""

if sys.version_info >= (3, 13):
    TESTED.remove("ecos")


def test_the_test_extra_installs_what_it_says():
    assert {f"qpsolvers:{solver}" for solver in TESTED} <= set(INSTALLED)
    assert {"cvxpy:clarabel", "cvxpy:osqp", "cvxpy:scs"} <= set(INSTALLED)


def test_a_member_is_an_instance_that_is_made_by_its_name():
    backend = backends.get_backend("qpsolvers:piqp")
    assert (backend.name, backend.package, backend.licence) == ("qpsolvers:piqp", "piqp", "BSD-2-Clause")
    assert list(backend.options()) == ["eps", "settings"]
    assert backends.get_backend("cvxpy:piqp").name == "cvxpy:piqp"
    assert backend.name == "qpsolvers:piqp"  # what is told of one is not told of the class
    assert cq.backend_names() == [name for name in backends.TABLE if not name.endswith(":")]
    assert backends.kind_of("cvxpy:scs") == "cvxpy family"


@pytest.mark.parametrize("name", ["qpsolvers", "qpsolvers:"])
def test_a_family_alone_is_told_how_its_solvers_are_named(name):
    told = rf"unknown backend '{name}': its solvers are named as 'qpsolvers:NAME'; installed: qpsolvers:.*; known: qp"
    with pytest.raises(cq.UnknownBackendError, match=told) as caught:
        backends.get_backend(name)
    assert "qpalm" not in str(caught.value).split("known")[0]


@pytest.mark.parametrize("name", ["cvxpy:quadprog", "qpsolvers:no-such-solver"])
def test_a_solver_that_nobody_finds_is_unknown(name):
    with pytest.raises(cq.UnknownBackendError, match=f"unknown backend '{name}'"):
        cq.solve(BOWL, name)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("qpsolvers:gurobi", r"qpsolvers knows the solver 'gurobi', but .*; type: pip install 'qpsolvers\[gurobi\]'"),
        ("qpsolvers:jaxopt_osqp", r"type: pip install 'qpsolvers\[jaxopt\]'"),
        ("cvxpy:gurobi", r"cvxpy knows the solver 'gurobi', but .*; type: pip install 'cvxpy\[gurobi\]'"),
        ("cvxpy:cplex", "install it as cvxpy tells"),
    ],
)
def test_a_solver_that_is_known_and_not_installed(name, told):
    with pytest.raises(cq.MissingBackendError, match=f"backend '{name}' is missing: .*{told}"):
        backends.get_backend(name)
    assert cq.compare(BOWL, [name]).rows[0].status == "missing"


def test_a_mistyped_name_gets_a_suggestion():
    with pytest.raises(cq.UnknownBackendError, match=r"did you mean 'qpsolvers:quadprog'\?"):
        backends.get_backend("qpsolvers:quadprogg")


def test_a_solver_that_is_named_alone_is_looked_for_in_the_families():
    with pytest.raises(
        cq.UnknownBackendError, match=r"unknown backend 'piqp'; did you mean 'qpsolvers:piqp'\?; known: a"
    ):
        backends.get_backend("piqp")


def test_what_is_missing_is_told_with_what_to_type(monkeypatch):
    installed = base._version
    monkeypatch.setattr(base, "_version", lambda name: None if name in ("qpsolvers", "piqp") else installed(name))
    with pytest.raises(cq.MissingBackendError) as caught:
        cq.solve(BOWL, "qpsolvers:piqp")
    assert str(caught.value) == (
        "backend 'qpsolvers:piqp' needs the packages 'qpsolvers' and 'piqp', which are not installed; "
        "type: pip install qpsolvers piqp"
    )
    names, left_out = backends.all_backends(BOWL.problem)
    assert "qpsolvers:scs" not in names
    assert "type: pip install qpsolvers" in left_out["qpsolvers:scs"]
    assert "cvxpy:scs" in names


def test_a_solver_that_is_installed_and_not_found_is_missing(monkeypatch):
    monkeypatch.setattr(families, "_found", lambda member: ("osqp", "scs"))
    with pytest.raises(
        cq.MissingBackendError, match=r"needs qpsolvers to find the solver 'piqp', but it finds osqp, scs"
    ):
        cq.solve(BOWL, "qpsolvers:piqp")


def test_a_package_that_cannot_be_loaded_finds_nothing(monkeypatch):
    def broken(module):
        raise ImportError("built for another numpy")

    class Broken(families.Member):
        family = "qpsolvers"

        @staticmethod
        def offered(library):
            raise AssertionError

    monkeypatch.setattr(families, "loaded", broken)
    assert "piqp" in Broken.names()
    assert not Broken.knows("gurobi")


def test_a_solver_without_a_row_is_called_as_it_is_shipped(monkeypatch):
    def toy(problem, initvals=None, verbose=False, **settings):
        found = qpsolvers.Solution(problem)
        found.found, found.x = (
            True,
            qpsolvers.solve_problem(problem, "osqp", eps_abs=1e-10, eps_rel=1e-10, **settings).x,
        )
        return found

    table = getattr(qpsolvers, "_internals", qpsolvers.solvers).solve_function  # where releases before 4.9 look
    monkeypatch.setitem(table, "toy", toy)
    monkeypatch.setattr(qpsolvers, "available_solvers", [*qpsolvers.available_solvers, "toy"])
    families._found.cache_clear()
    try:
        assert "qpsolvers:toy" in backends.family_names()
        solution = cq.solve(BOWL, "qpsolvers:toy")
        assert (solution.status, solution.iterations, solution.termination) == ("certified", 1, "solved")
    finally:
        families._found.cache_clear()


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name == "cvxpy:cvxopt")) for name in INSTALLED]
)
def test_every_member_passes_the_conformance_kit(name):
    report = check_backend(name)
    assert report.ok, report


@pytest.mark.parametrize("name", INSTALLED)
@pytest.mark.parametrize("tol", ["low", "mid", "default"])
def test_settings_have_the_same_names_as_for_others(name, tol):
    solution = cq.solve(BOWL, name, tol=tol, on_failure="ignore")
    reachable = backends.get_backend(name).reachable_tol or 1e-4
    if tol == "default":
        assert solution.note.endswith("calls it by default")
        assert np.isfinite(solution.gap).all()
    elif reachable <= solution.tol:
        assert solution.status == "certified"


def test_false_claims_are_counted():
    comparison = cq.compare(BOWL, ["qpsolvers:scs", "cvxpy:scs", "active-set"], tol="default")
    assert list(comparison.false_claims) == ["qpsolvers:scs", "cvxpy:scs"]
    assert "said 'solved', and its gap is wrong by at least" in comparison.false_claims["qpsolvers:scs"]
    assert set(comparison.provenance.versions) >= {"qpsolvers", "cvxpy", "scs"}


def test_with_their_defaults_solvers_get_what_the_user_gives_and_nothing_else(monkeypatch):
    told = []
    call = qpsolvers.solve_problem
    monkeypatch.setattr(qpsolvers, "solve_problem", lambda *a, **k: told.append(k) or call(*a, **k))
    cq.solve(BOWL, "qpsolvers:scs", tol="default", on_failure="ignore")
    cq.solve(BOWL, "qpsolvers:scs", tol="default", eps=1e-3, settings={"alpha": 1.0}, on_failure="ignore")
    cq.solve(BOWL, "qpsolvers:scs", tol="default", max_iter=7, time_limit=60.0, on_failure="ignore")
    assert told[0] == {"initvals": None}
    assert told[1] == {"initvals": None, "eps_abs": 1e-3, "alpha": 1.0}
    assert told[2]["max_iters"] == 7
    assert 0 < told[2]["time_limit_secs"] <= 60.0


def test_a_tolerance_is_told_by_the_solvers_own_settings_and_tightened(monkeypatch):
    told = []
    call = qpsolvers.solve_problem
    monkeypatch.setattr(qpsolvers, "solve_problem", lambda *a, **k: told.append(k) or call(*a, **k))
    assert cq.solve(HEXAGON, "qpsolvers:scs", tol=1e-6).status == "certified"
    # How many rounds there are is the solver's release's affair.
    assert [settings["eps_abs"] for settings in told] == pytest.approx([1e-6, 1e-7][: len(told)])
    told.clear()
    cq.solve(BOWL, "qpsolvers:cvxopt", eps=1e-9, on_failure="ignore")
    assert told[0]["abstol"] == told[0]["reltol"] == 1e-9


@pytest.mark.parametrize("settings", [3, {1: 2}, "fast"])
def test_settings_that_are_no_names_and_values_are_refused(settings):
    with pytest.raises(TypeError, match="settings must map names of the solver's own settings to values, got"):
        cq.solve(BOWL, "qpsolvers:piqp", settings=settings)
    with pytest.raises(ValueError, match="eps must be > 0"):
        cq.solve(BOWL, "cvxpy:scs", eps=0.0)


@pytest.mark.parametrize(
    "name", [name for name in INSTALLED if backends.get_backend(name).iteration_unit == "iteration"]
)
def test_iteration_limits_are_passed_on(name):
    solution = cq.solve(BOWL, name, max_iter=2, on_failure="ignore")
    assert solution.iterations <= 2
    assert solution.status in ("iteration_limit", "failed")


@pytest.mark.parametrize("name", INSTALLED)
def test_time_limits_are_kept(name):
    solution = cq.solve(BOWL, name, time_limit=1e-4, tol=1e-12, on_failure="ignore")
    assert solution.status == "time_limit"


def test_definite_matrices_are_needed_by_those_that_factor_them():
    for name in INSTALLED:
        backend = backends.get_backend(name)
        assert (Need.DEFINITE in backend.does_without) is not SOLVERS[name.split(":")[1]].definite


@pytest.mark.parametrize("name", ["cvxpy:clarabel", "qpsolvers:piqp"])
def test_a_session_takes_other_loads(name):
    solver = cq.Solver(BOWL, name)
    for load in (4.0, 8.0, 6.0):
        assert solver.solve(load=load).status == "certified"


def test_cvxpy_needs_no_memory_that_grows_as_the_square():
    tracemalloc.start()
    try:
        cq.solve(cq.gallery.bowl(40), "cvxpy:scs", tol="low", on_failure="ignore")
        assert tracemalloc.get_traced_memory()[1] < 1600**2 * 8
    finally:
        tracemalloc.stop()


def test_a_problem_without_bounds_is_solved_by_those_that_want_a_row_too():
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0], lower=-np.inf)
    for name in INSTALLED:
        assert cq.solve(problem, name, tol=1e-4).gap == pytest.approx([-1 / 3, -5 / 3], abs=1e-3)


def test_bounds_that_almost_meet_are_equations():
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0], lower=0.0, upper=[1e-12, 2.0])
    for name in INSTALLED:
        solution = cq.solve(problem, name, tol=max(1e-6, backends.get_backend(name).reachable_tol or 0.0))
        assert solution.status == "certified"
        assert solution.gap == pytest.approx([1e-12, 0.0], abs=1e-4)


def test_all_names_everybody_or_tells_why_not():
    names, left_out = backends.all_backends(HEXAGON.problem)
    assert sorted([*names, *left_out]) == sorted([*cq.backend_names(), *backends.names_besides()])
    assert left_out["qpsolvers:quadprog"] == "is practical up to 1000 unknowns"
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0], lower=0.0, upper=[0.1, 2.0])
    comparison = cq.compare(problem, "all")
    assert [row.backend for row in comparison.rows] == backends.all_backends(problem)[0]
    assert comparison.agree, repr(comparison)
    assert comparison.left_out["multigrid"].startswith("needs a problem on a lattice")
    assert "Left out: mangasarian needs a problem without an upper bound" in repr(comparison)


def test_one_name_alone_is_not_taken_for_all():
    with pytest.raises(TypeError, match=r"got 'psor' alone; write \['psor'\], or 'all'"):
        cq.compare(BOWL, "psor")


@pytest.mark.slow
def test_all_on_the_hexagon_are_in_the_table_or_explained():
    code = "from contactqp_command import main; main()"
    command = [sys.executable, "-c", code, "compare", "examples/hexagon.toml", "--backends", "all"]
    run = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert run.stderr == ""
    table, _, left_out = run.stdout.partition("Left out: ")
    explained = left_out.replace(",", " ").replace(": ", " ").split()
    for name in [*cq.backend_names(), *backends.names_besides()]:
        assert f"\n{name} " in table or name in explained
    assert run.returncode == 0, run.stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in INSTALLED if backends.get_backend(name).reachable_tol])
def test_the_hexagon_is_certified_to_the_tolerance_in_the_table(name):
    assert cq.solve(HEXAGON, name, tol=backends.get_backend(name).reachable_tol).status == "certified"


@pytest.mark.slow
@pytest.mark.parametrize("family", ["qpsolvers", "cvxpy"])
def test_nothing_is_printed_by_a_fresh_process(family):
    names = [name for name in INSTALLED if name.startswith(f"{family}:")]
    code = f"""
        import contactqp as cq
        for name in {names}:
            for problem in (cq.gallery.islands(), cq.ContactQP([[2.0]], [-1.0]), cq.gallery.bowl(9)):
                for tol in (1e-3, "default"):
                    cq.solve(problem, name, tol=tol, on_failure="ignore")
    """
    run = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=True)
    assert (run.stdout, run.stderr) == ("", "")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "nodes", "after"),
    [("qpsolvers:highs", 60, 4.0), ("qpsolvers:piqp", 150, 4.0), ("qpsolvers:osqp", 200, 1.0), ("cvxpy:scs", 150, 4.0)],
)
def test_ctrl_c_ends_a_long_solve_within_a_second(name, nodes, after):
    assert seconds_to_answer(name, nodes, 1e-12, after) < PROMPTLY


def test_ctrl_c_that_a_solver_takes_for_itself_is_passed_on(monkeypatch):
    """SCS and OSQP end then, and CVXPY says only that they have failed."""
    scs = pytest.importorskip("scs")
    monkeypatch.setattr(scs, "solve", lambda *given, **more: {"info": {"status": "interrupted", "status_val": -5}})
    with pytest.raises(KeyboardInterrupt):
        cq.solve(BOWL, "cvxpy:scs")


@pytest.fixture
def always_elsewhere(monkeypatch):
    """PIQP is called in a process of its own at any size; returned are all those that were started."""
    monkeypatch.setitem(SOLVERS, "piqp", replace(SOLVERS["piqp"], quick=0))
    started = []
    monkeypatch.setattr(
        subprocess, "Popen", lambda *a, _start=subprocess.Popen, **k: started.append(_start(*a, **k)) or started[-1]
    )
    return started


@pytest.mark.slow
def test_a_process_serves_all_loads_of_a_session_and_ends_with_it(always_elsewhere):
    solver, here = cq.Solver(BOWL, "qpsolvers:piqp"), cq.Solver(BOWL, "cvxpy:clarabel")
    for load in (4.0, 6.0):
        solution = solver.solve(load=load)
        assert solution.status == "certified"
        np.testing.assert_allclose(solution.gap, here.solve(load=load).gap, atol=1e-6)
    assert [process.poll() for process in always_elsewhere] == [None]
    with pytest.raises(TypeError):
        cq.solve(BOWL, "qpsolvers:piqp", settings={"max_iter": "many"})
    assert cq.solve(BOWL, "qpsolvers:piqp").status == "certified"
    assert [process.poll() is None for process in always_elsewhere] == [True, False, False]
    del solver
    gc.collect()
    assert all(process.poll() is not None for process in always_elsewhere)


@pytest.mark.slow
def test_a_process_that_is_lost_is_told_and_another_is_started(always_elsewhere, monkeypatch):
    solver = cq.Solver(BOWL, "qpsolvers:piqp")
    assert solver.solve().status == "certified"
    always_elsewhere[0].kill()
    lost = solver.solve(load=5.0, on_failure="ignore")
    assert lost.status == "failed"
    assert "its process ended with code" in lost.termination
    assert solver.solve(load=5.0).status == "certified"
    assert len(always_elsewhere) == 2


def test_where_no_process_can_be_started_and_for_what_cannot_be_sent_there_is_none(always_elsewhere, monkeypatch):
    assert cq.solve(BOWL, "qpsolvers:piqp", settings={"verbose": Unsendable()}).status == "certified"
    monkeypatch.setattr(sys, "executable", "/usr/bin/an-application")
    assert cq.solve(BOWL, "qpsolvers:piqp").status == "certified"
    assert always_elsewhere == []


class Unsendable(int):
    def __reduce_ex__(self, protocol):
        raise TypeError("it stays here")


@pytest.mark.slow
def test_time_limits_end_what_does_not_look_at_the_clock():
    started = time.perf_counter()
    solution = cq.solve(cq.gallery.bowl(150), "qpsolvers:piqp", time_limit=4.0, on_failure="ignore")
    assert solution.status == "time_limit"
    assert time.perf_counter() - started < 4.0 + PROMPTLY


def test_two_threads_may_call_different_packages_at_once():
    answers = {}

    def solve(name):
        answers[name] = cq.solve(cq.gallery.bowl(31), name, on_failure="ignore").status

    threads = [threading.Thread(target=solve, args=(name,)) for name in ("qpsolvers:piqp", "cvxpy:clarabel")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers == dict.fromkeys(("qpsolvers:piqp", "cvxpy:clarabel"), cq.Status.CERTIFIED)


@pytest.mark.parametrize("name", INSTALLED)
def test_a_misspelt_setting_is_refused_before_anything_is_solved(name, monkeypatch):
    monkeypatch.setattr(families.MemberState, "set_up", lambda *_: pytest.fail("it was set up"))
    facts = SOLVERS[name.split(":")[1]]
    one = (facts.iterations, *facts.tolerances, *facts.setting_names)
    meant = next(filter(None, one))
    with pytest.raises(TypeError, match=rf"backend '{name}' has no setting '{meant}s'; did you mean '{meant}"):
        cq.solve(BOWL, name, settings={f"{meant}s": 1})


def test_a_solver_whose_settings_are_not_known_is_told_all_of_them():
    check_setting_names("qpsolvers:toy", facts_of("toy", "qpsolvers"), "qpsolvers", ["anything"])
    elsewhere = replace(SOLVERS["piqp"], settings_at="piqp:NoSuchThing()")
    check_setting_names("qpsolvers:piqp", elsewhere, "qpsolvers", ["anything"])


@pytest.mark.parametrize("name", [name for name in INSTALLED if name.startswith("qpsolvers:")])
def test_qpsolvers_own_setting_is_taken_for_every_solver(name):
    solver = name.removeprefix("qpsolvers:")
    check_setting_names(name, SOLVERS[solver], "qpsolvers", ["verbose"])
