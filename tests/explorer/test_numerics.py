"""The page's JavaScript, run by node, against Python: the same problems, answers and proofs."""

import json
import shutil
import subprocess
from fractions import Fraction

import numpy as np
import pytest
from rational import exact_solution

import contactqp as cq
from contactqp.explorer.scenes import MOST_NODES, Scene, shown
from contactqp.explorer.scripts import NUMERICS, script
from contactqp.proof.lattice_measures import LatticeMeasures

NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="node is not installed")

HARNESS = """
const tasks = JSON.parse(require("fs").readFileSync(0, "utf8"));
const vector = (lattice, grid) => Array.from(lattice.nodes, (p) => grid[p]);
const told = (lattice, found) => ({
  lower: vector(lattice, found.lower), upper: vector(lattice, found.upper).map(String),
  state: vector(lattice, found.state), reaction: vector(lattice, found.reaction), bound: String(found.bound),
});
const answers = tasks.map(({ scene: record, wish, tol, gap, beta, sweeps, race }) => {
  const scene = unpackScene(record), problem = problemOf(scene, wish), { lattice } = problem;
  const barrier = parabolaBarrier(lattice), q = vector(lattice, problem.q), height = vector(lattice, problem.height);
  if (gap) {
    const omega = new Float64Array(lattice.mask.length);
    lattice.nodes.forEach((p, k) => (omega[p] = Number(gap[k])));
    return { q, ...told(lattice, certify(problem, barrier, omega)) };
  }
  if (sweeps) {
    const omega = new Float64Array(lattice.mask.length);
    for (let k = 0; k < sweeps; k++) relaxationSweep(problem, omega, beta);
    return { gap: vector(lattice, omega) };
  }
  const answer = solveContact(problem, barrier, tol);
  if (!race) return { height, q };
  const finest = vector(lattice, solveContact(problem, barrier, 1e-15).gap);  // as far as rounding allows
  const steps = [...multigridSteps(problem, barrier, tol)];
  const relaxed = [...relaxationSteps(problem, barrier, tol, 1.7, 20000)];
  return {
    q, finest, gap: vector(lattice, answer.gap), ...told(lattice, answer.certificate), cycles: answer.cycles,
    certified: answer.certified, work: steps.map((step) => step.work), bounds: steps.map((step) => step.bound),
    relaxed: relaxed[relaxed.length - 1],
  };
});
process.stdout.write(JSON.stringify(answers));
"""


def in_node(*tasks):
    """Return what the page makes of each task."""
    code = f'"use strict";\n{script(*NUMERICS, "scene")}\n{HARNESS}'
    run = subprocess.run([NODE, "-e", code], input=json.dumps(tasks), capture_output=True, text=True, timeout=60)
    assert run.returncode == 0, run.stderr[-2000:]
    return json.loads(run.stdout)


def task(model, **wanted):
    record = Scene("it", model).record()
    wish = {"support": "the case's own", "lift": 0, "relief": 1}
    wish |= {"load": record["load"]["value"], "tension": record["tension"]["value"]}
    return {"scene": record, "wish": wish | wanted.pop("wish", {}), **wanted}


def square(nodes, **options):
    lattice = cq.Frame.rectangle(1.0, 1.0, center=(0.5, 0.5)).lattice(spacing=1 / (nodes + 1))
    return cq.Membrane(lattice, **{"tension": 1.0, "load": 8.0, "support": 0.2, **options})


def tilted(x, y):
    return 0.05 * x - 0.02 * y


MODELS = {
    "hexagon": lambda: cq.gallery.paper_hexagon(),
    "cable": lambda: cq.Cable(span=100.0, spacing=1.0, tension=1000.0, load=2.0, support=0.9),
    "three nodes": lambda: cq.Cable(nodes=3, spacing=0.7, tension=3.0, load=1.0, support=0.2),
    "tilted frame": lambda: square(20, frame_height=tilted, tension=3.0, load=20.0),
    "upwards": lambda: square(17, support=-0.2, upwards=True, frame_height=tilted),
    "pits": lambda: square(31, support=lambda x, y: np.where(abs(x - 0.5) < 0.2, 0.1, np.inf), frame_height=0.03),
    "two tensions": lambda: square(24, tension=(2.0, 0.3)),
    "load that varies": lambda: square(15, load=lambda x, y: 20 * (x - 0.3), support=lambda x, y: 0.05 + x * y / 9),
    "strip": lambda: cq.Membrane(cq.Frame.rectangle(6.0, 0.5).lattice(0.05), tension=1.0, load=1.0, support=0.02),
}


@pytest.fixture(scope="module")
def answers():
    """Models, their solutions by Python, and those of the page."""
    models = {name: make() for name, make in MODELS.items()}
    found = in_node(*(task(model, tol=1e-10, race=True) for model in models.values()))
    return {name: (model, answer) for (name, model), answer in zip(models.items(), found, strict=True)}


@needs_node
@pytest.mark.parametrize("name", MODELS)
def test_the_page_poses_and_solves_the_same_problem(answers, name):
    model, answer = answers[name]
    problem = model.problem
    forces = np.abs(problem.q).max() + np.abs(model.nodal_load).max()
    np.testing.assert_allclose(answer["q"], problem.q, rtol=0, atol=1e-12 * forces)
    solution = cq.solve(model, tol=1e-12, on_failure="ignore")
    scale = np.abs(solution.deflection).max()
    np.testing.assert_allclose(answer["gap"], solution.gap, rtol=0, atol=1e-10 * scale)
    np.testing.assert_allclose(answer["finest"], solution.gap, rtol=0, atol=1e-12 * scale)
    assert answer["certified"]
    assert [answer["state"].count(k) for k in (3, 1)] == [solution.contact.sum(), (~solution.contact).sum()]
    assert answer["relaxed"]["bound"] <= 1e-10


@needs_node
@pytest.mark.parametrize("name", ["hexagon", "two tensions", "pits", "cable"])
def test_its_multigrid_does_the_same_work_and_contracts_as_fast(answers, name):
    model, answer = answers[name]
    solution = cq.solve(model, "multigrid", tol=1e-10, history=True, on_failure="ignore")
    work = solution.history["work"]
    # A record of Python's is made at the end of a cycle, the page's after its sweeps.
    assert answer["work"][0] < work[0] < answer["work"][1]
    assert abs(answer["cycles"] - solution.iterations) <= 1


def wrong_answers(model, rng, count=6):
    """Yield gaps near the solution and far from it, infeasible ones among them."""
    gap = cq.solve(model, tol=1e-10, on_failure="ignore").gap
    scale = np.abs(gap).max()
    for size in 10.0 ** np.linspace(-15, 0, count):
        yield gap + size * scale * rng.standard_normal(gap.size)
    yield np.zeros_like(gap)


@pytest.fixture(scope="module")
def proofs():
    """Models, wrong answers to them, and what the page proves of these."""
    rng, tasks = np.random.default_rng(3), []
    found = {name: (model := make(), list(wrong_answers(model, rng))) for name, make in MODELS.items()}
    for model, gaps in found.values():
        record = task(model)
        tasks += [record | {"gap": gap.tolist()} for gap in gaps]
    proven = iter(in_node(*tasks))
    return {name: (model, [(gap, next(proven)) for gap in gaps]) for name, (model, gaps) in found.items()}


@needs_node
@pytest.mark.parametrize("name", MODELS)
def test_its_certificate_is_that_of_python(proofs, name):
    model, judged = proofs[name]
    problem = model.problem
    for gap, found in judged:
        expected = LatticeMeasures(problem, problem.barrier, gap).certificate()
        scale = np.abs(gap).max() + np.abs(model.reference[model.supported]).max()
        tight = {"rtol": 1e-12, "atol": 1e-12 * scale}
        np.testing.assert_allclose(found["lower"], expected.lower, **tight)
        np.testing.assert_allclose(np.array(found["upper"], dtype=float), expected.upper, **tight)
        assert float(found["bound"]) == pytest.approx(expected.gap_bound, rel=1e-12, abs=1e-12 * scale)
        reaction = problem.reaction(gap)
        np.testing.assert_allclose(found["reaction"], reaction, rtol=0, atol=1e-12 * np.abs(reaction).max() + 1e-14)
        states = np.array(found["state"])
        assert np.array_equal(states == 3, expected.contact)
        assert np.array_equal(states == 1, expected.clear & ~expected.contact)


def small_models(rng, count):
    """Yield problems of a few nodes, some of them without a support."""
    for _ in range(count):
        rows, columns = rng.integers(1, 4, size=2)
        mask = rng.random((rows, columns)) < 0.8
        mask[0, 0] = True
        size = int(mask.sum())
        support = np.where(rng.random(size) < 0.8, rng.uniform(-0.5, 1.0, size) * 10.0 ** rng.integers(-3, 2), np.inf)
        if np.isinf(support).all():
            support[0] = 0.1
        yield cq.Membrane(cq.Lattice.from_mask(mask, 1.0), tension=1.0, load=rng.uniform(-1, 2, size), support=support)


@needs_node
@pytest.mark.filterwarnings("ignore::contactqp.ContactWarning")
def test_its_bounds_hold_in_rational_numbers():
    """For the numbers that it has in memory, whatever the answer: nothing is off by as much as a rounding."""
    rng = np.random.default_rng(11)
    models = list(small_models(rng, 25))
    gaps = [list(wrong_answers(model, rng, 4)) for model in models]
    tasks = [task(model, gap=gap.tolist()) for model, several in zip(models, gaps, strict=True) for gap in several]
    found = iter(in_node(*tasks))
    for model, several in zip(models, gaps, strict=True):
        exact = None
        for gap in several:
            proven = next(found)
            if exact is None:
                exact = exact_solution(model.problem.with_forces(proven["q"]))
            for k, (true, reaction) in enumerate(zip(*exact, strict=True)):
                assert Fraction(proven["lower"][k]) <= true <= Fraction(float(proven["upper"][k]))
                assert abs(true - Fraction(float(gap[k]))) <= Fraction(float(proven["bound"]))
                assert {1: true > 0 or not model.supported[k], 2: True, 3: reaction > 0}[proven["state"][k]]


@needs_node
def test_numbers_that_overflow_prove_nothing():
    model = MODELS["three nodes"]()
    [found] = in_node(task(model, gap=["1e308", "-1e308", "NaN"]))
    assert found["bound"] == "Infinity"
    assert (found["lower"], found["upper"], found["state"]) == ([0] * 3, ["Infinity"] * 3, [2] * 3)


@needs_node
def test_its_sweeps_are_those_of_python():
    model = square(12, support=0.1)
    [found] = in_node(task(model, sweeps=7, beta=1.6))
    solution = cq.solve(model, "psor", relaxation=1.6, max_iter=7, on_failure="ignore")
    np.testing.assert_allclose(found["gap"], solution.gap, rtol=0, atol=1e-13)


@needs_node
def test_sliders_make_the_models_that_they_say():
    model = square(14, tension=2.0, support=lambda x, y: 0.2 + 0.3 * (x - 0.5) ** 2)
    wish = {"load": 11.0, "tension": 3.0, "lift": 0.05, "relief": 1.5}
    [found] = in_node(task(model, tol=1e-10, wish=wish))
    summit = model.support.min()
    moved = cq.Membrane(model.lattice, tension=3.0, load=11.0, support=summit + 1.5 * (model.support - summit) - 0.05)
    np.testing.assert_allclose(found["height"], moved.support, atol=1e-15)
    np.testing.assert_allclose(found["q"], moved.problem.q, atol=1e-13)


# What it refuses.


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: square(4, tension=lambda x, y: 1 + x), ValueError, "its tension varies from place to place"),
        (lambda: square(4, ceiling=-1.0), ValueError, "it has a ceiling"),
        (lambda: square(4, foundation=1.0), ValueError, "it has an elastic foundation"),
        (
            lambda: cq.Membrane(cq.Frame.disk(1.0).lattice(0.2, fitted=True), tension=1.0, load=1.0, support=0.1),
            ValueError,
            "its lattice is fitted to the contour",
        ),
        (lambda: square(549), ValueError, f"it has 301401 nodes, of at most {MOST_NODES}; take a larger spacing"),
        (
            lambda: cq.Beam(10.0, spacing=1.0, bending_stiffness=1.0, tension=1.0, load=1.0, support=1.0),
            TypeError,
            "the explorer shows a Membrane or a Cable, got Beam",
        ),
    ],
)
def test_models_that_it_does_not_solve_are_refused_in_words(make, error, message):
    with pytest.raises(error, match=message):
        shown(make())


def test_loads_that_are_nothing_have_a_slider_all_the_same():
    record = Scene("it", square(5, load=0.0)).record()
    assert record["load"]["value"] == 0.0 < record["load"]["most"]
