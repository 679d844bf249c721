"""PETSc, in a worker of the interpreter that has it: certified as others are, on one and two ranks, and apart."""

import os
import re
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest
from ctrl_c import PROMPTLY, seconds_to_answer
from meshes import bowl_on_triangles

import contactqp as cq
from contactqp import backends
from contactqp.algebra.stencil import Stencil
from contactqp.backends import petsc, petsc_place
from contactqp.methods.factors import DIRECT_SIZE
from contactqp.testing import check_backend

MISSING = backends.why_missing("petsc")
INTERPRETER = petsc_place.interpreter()
HEXAGON = cq.gallery.paper_hexagon()
COMING_FROM = Path(__file__).parents[2] / "docs" / "coming-from" / "petsc.md"

installed = pytest.mark.skipif(MISSING is not None, reason=str(MISSING))
with_ranks = pytest.mark.skipif(INTERPRETER is None or INTERPRETER.mpiexec is None, reason="there is no mpiexec")


@pytest.fixture
def started(monkeypatch):
    """All processes that are started."""
    found = []
    monkeypatch.setattr(
        subprocess, "Popen", lambda *a, _start=subprocess.Popen, **k: found.append(_start(*a, **k)) or found[-1]
    )
    return found


@pytest.fixture
def nowhere(monkeypatch):
    monkeypatch.setattr(petsc, "interpreter", lambda: None)


def test_what_to_install_is_told_where_it_is_missing(nowhere):
    with pytest.raises(
        cq.MissingBackendError,
        match=r"backend 'petsc' needs the package 'petsc4py', which is not installed; type: apt install python3-pe"
        r".*conda install -c conda-forge petsc4py.*CONTACTQP_PETSC_PYTHON",
    ):
        cq.solve(HEXAGON, "petsc")
    assert cq.compare(HEXAGON, ["petsc"]).rows[0].status == "missing"


def test_it_is_asked_by_its_name_and_by_no_default():
    assert "petsc" not in cq.backend_names()
    assert "petsc" not in backends.usual_backends(HEXAGON.problem)[0]
    assert backends.names_besides()[0] == "petsc"
    with pytest.raises(cq.UnknownBackendError, match=r"did you mean 'petsc'\?"):
        cq.solve(HEXAGON, "petcs")


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"ranks": 0}, ValueError, "ranks must be >= 1, got 0"),
        ({"petsc_options": "gamg"}, TypeError, "petsc_options must map names of the solver's own settings to values"),
        ({"petsc_options": {"-pc_type": "lu"}}, ValueError, "petsc_options must have names without a dash, got '-pc_t"),
        ({"petsc_options": {"pc_type": ["lu"]}}, TypeError, r"petsc_options must have .* 'pc_type' is \['lu'\]"),
        ({"history": 1}, TypeError, "history must be True or False"),
        ({"eps": 0.0}, ValueError, "eps must be > 0"),
    ],
)
@installed
def test_bad_options_say_what_is_wrong(options, error, message):
    with pytest.raises(error, match=message):
        cq.solve(HEXAGON, "petsc", **options)


@installed
@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=with_ranks)])
def test_the_hexagon_is_certified_and_its_steps_are_told(ranks):
    solution = cq.solve(HEXAGON, "petsc", ranks=ranks, history=True)
    assert solution.status == "certified"
    assert solution.termination.startswith("CONVERGED_FNORM_ABS")
    np.testing.assert_array_equal(solution.contact, cq.solve(HEXAGON, "active-set").contact)
    active, changed, residual = (solution.history[name] for name in ("active", "changed", "residual"))
    assert len(active) == len(changed) == len(residual) == solution.iterations > 1
    assert active[-1] == solution.contact.sum()
    assert changed[0] > 0 == changed[-1]
    assert residual[-1] < 1e-6 * residual[0]


@installed
@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=with_ranks)])
@pytest.mark.parametrize("shape", [(70, 61), (1, 4101)])
def test_a_lattice_with_gaps_and_two_bounds_is_solved_by_multigrid_on_coarser_lattices(shape, ranks):
    rng = np.random.default_rng(1)
    mask = np.ones(shape, dtype=bool)
    mask[20:40, 30:35] = False
    rows, columns = shape
    arms = rng.uniform(0.5, 5.0, (rows, columns + 1)), rng.uniform(0.5, 5.0, (rows + 1, columns)) * (rows > 1)
    stencil = Stencil(mask, *arms)
    lower, upper = (
        np.where(rng.random(stencil.size) < 0.1, far, near) for far, near in ((-np.inf, 0.0), (np.inf, 0.5))
    )
    problem = cq.ContactQP(stencil, rng.uniform(-0.1, 0.11, stencil.size), lower=lower, upper=upper)
    solution = cq.solve(problem, "petsc", ranks=ranks, history=True)
    exact = cq.solve(problem, "active-set", tol=1e-9)
    assert problem.size > DIRECT_SIZE
    assert solution.status == "certified"
    np.testing.assert_allclose(solution.gap, exact.gap, atol=1e-6 * problem.gap_scale)
    held = (exact.gap == lower) | (exact.gap == upper)
    assert held.any()
    assert solution.history["active"][-1] == held.sum()


@installed
@pytest.mark.slow
@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=with_ranks)])
def test_a_mesh_between_two_bounds_is_solved_by_multigrid(ranks):
    matrix, forces = bowl_on_triangles(64)
    problem = cq.ContactQP(matrix, forces, lower=0.0, upper=0.06)
    solution = cq.solve(problem, "petsc", ranks=ranks, history=True)
    exact = cq.solve(problem, "active-set", tol=1e-9)
    assert problem.size > DIRECT_SIZE
    assert solution.status == "certified"
    assert (exact.gap == 0.06).any()
    np.testing.assert_allclose(solution.gap, exact.gap, atol=1e-6 * problem.gap_scale)
    assert solution.iterations < 15  # from zero the contact set would move by a layer of nodes in each
    assert solution.history["active"][-1] == ((exact.gap == 0.0) | (exact.gap == 0.06)).sum()


@installed
def test_options_are_passed_on_by_name(tmp_path, capfd):
    file = tmp_path / "steps.txt"
    options = {"pc_type": "jacobi", "ksp_rtol": 1e-9, "snes_monitor": f"ascii:{file}"}
    solution = cq.solve(HEXAGON, "petsc", petsc_options=options)
    assert solution.status == "certified"
    told = re.findall(r"(\d+) SNES Function norm", file.read_text())
    assert [int(number) for number in told[: solution.iterations + 1]] == list(range(solution.iterations + 1))
    assert capfd.readouterr() == ("", "")
    cq.solve(HEXAGON, "petsc", petsc_options={"snes_vi_monitor": None})
    assert "SNES VI Function norm" in capfd.readouterr().err


@installed
def test_options_that_nothing_asks_for_are_told_once():
    options = {"ksp_rtoll": 1e-9, "ksp_atol": 1e-50, "pc_gamg_threshold": 0.1, "malloc_debug": False}
    solver = cq.Solver(HEXAGON, "petsc", petsc_options=options)  # few unknowns are factorised
    with pytest.warns(cq.ContactWarning, match="petsc_options has 'ksp_rtoll', 'pc_gamg_threshold', which ") as told:
        assert solver.solve().status == "certified"
    assert told[0].filename == __file__
    assert solver.solve(load=0.05).status == "certified"


@installed
def test_as_it_is_shipped_it_is_called_once():
    solution = cq.solve(HEXAGON, "petsc", tol="default", on_failure="ignore")
    assert solution.note == "SNESVI as PETSc is shipped: at most 50 steps, rtol 1e-8"
    assert solution.termination.startswith("CONVERGED_FNORM_RELATIVE")


@installed
@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=[with_ranks, pytest.mark.slow])])
def test_a_worker_that_fails_is_a_failed_answer_with_its_words(ranks, started):
    solution = cq.solve(HEXAGON, "petsc", ranks=ranks, petsc_options={"pc_type": "nosuch"}, on_failure="ignore")
    assert solution.status == "failed"
    assert "its process failed: Error: error code 86" in solution.termination
    assert "Unable to find requested PC type nosuch" in solution.termination
    assert started[-1].poll() is not None


@installed
@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=[with_ranks, pytest.mark.slow])])
def test_a_worker_that_is_killed_between_loads_is_started_again(ranks, started):
    solver = cq.Solver(HEXAGON, "petsc", ranks=ranks)
    assert solver.solve().status == "certified"
    os.killpg(started[-1].pid, signal.SIGKILL)
    started[-1].wait()
    assert solver.solve(load=0.05).status == "certified"
    assert solver.solve(load=0.02).status == "certified"
    assert len(started) == 2
    del solver
    assert started[-1].poll() is not None


@installed
def test_time_limits_are_kept():
    solution = cq.solve(cq.gallery.bowl(300), "petsc", time_limit=0.3, tol=1e-9, on_failure="ignore")
    assert solution.status == "time_limit"


@installed
@pytest.mark.slow
def test_ctrl_c_ends_the_worker_within_a_second():
    assert seconds_to_answer("petsc", 400, 1e-10) < PROMPTLY


@installed
@pytest.mark.slow
def test_it_passes_the_conformance_kit():
    report = check_backend("petsc")
    assert report.ok, report


@installed
@pytest.mark.slow
def test_the_hexagon_is_certified_down_to_its_reachable_tolerance():
    solver = cq.Solver(HEXAGON, "petsc", tol=petsc.Petsc.reachable_tol)
    assert [solver.solve(load=load).status.value for load in cq.gallery.PAPER_LOADS] == ["certified"] * 10


@installed
def test_the_program_that_the_page_for_its_users_shows_runs_and_is_certified(tmp_path):
    code = re.search(r"```py\n(.*?)```", COMING_FROM.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert code is not None
    problem = cq.gallery.bowl(15).problem
    matrix = problem.G.tocsr()
    np.savez(tmp_path / "given.npz", forces=problem.q, indptr=matrix.indptr, indices=matrix.indices, data=matrix.data)
    before = """
        import types, numpy as np, petsc4py
        petsc4py.init(["", "-snes_rtol", "1e-10", "-pc_type", "lu"])
        from petsc4py import PETSc
        given = np.load("given.npz")
        G = types.SimpleNamespace(**given, shape=2 * given["forces"].shape)
        forces = PETSc.Vec().createWithArray(given["forces"])
    """
    program = "\n".join(line.strip() for line in before.splitlines()) + code[1] + 'np.save("gap.npy", x.getArray())\n'
    found = {**os.environ, **INTERPRETER.environment}
    subprocess.run([INTERPRETER.path, "-c", program], cwd=tmp_path, check=True, capture_output=True, env=found)
    certificate = cq.certify(problem, np.load(tmp_path / "gap.npy"))
    assert certificate.gap_bound < 1e-6 * problem.gap_scale
