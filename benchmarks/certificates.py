"""How sharp certificates are, and what they cost; ratios are measured in one process.

    python benchmarks/certificates.py [sharpness] [beyond] [cost] [--problems NAME ...] [--sizes 255 511 1023]

sharpness: bound over true error, for the answers of every backend to problems of the gallery at three tolerances. The
true error is known to rounding from an enclosure that is sharp to rounding; answers that are exact to rounding
themselves (an error below 1e-14 of the gap scale) are listed, but are not part of the median.
``--problems`` takes some of them, by the names that are printed.
beyond: the same for matrices that are no M-matrices, meshes of triangles, beams, plates and random ones, at tolerances
down to 1e-10.
cost: time of the fast certificate in lexicographic PSOR sweeps over the same lattice, and the largest memory it takes
on top of problem and answer, in vectors of the lattice's size; the same for the sharp one.
"""

from __future__ import annotations

import argparse
import sys
import time
import tracemalloc
import warnings
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

import contactqp as cq
from contactqp.backends import suitable_backends
from contactqp.methods.sor.sweepers import LatticeSweeper

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from meshes import beam_on_floor, bowl_on_triangles, plate_over_bowl

TOLERANCES = (1e-3, 1e-6, 1e-9)
TOLERANCES_BEYOND = (1e-6, 1e-8, 1e-10)
ROUNDING = 1e-14
LARGEST_LINEAR_PROGRAM = 3000


def problems() -> Iterator[tuple[str, cq.Membrane | cq.Cable]]:
    for load in (0.01, 0.03, 0.1):
        yield f"hexagon {load:g}", cq.gallery.paper_hexagon(load)
    yield "bowl 63", cq.gallery.bowl(63)
    yield "bowl 127", cq.gallery.bowl(127)
    yield "spiral 63", cq.gallery.spiral(63)
    yield "ball 33", cq.gallery.ball(33)[0]
    yield "L with hole", cq.gallery.l_shape_with_hole(0.05)
    yield "islands", cq.gallery.islands()
    yield "cable 199", cq.gallery.cable_on_floor(199, 40)[0]


def matrices() -> Iterator[tuple[str, cq.ContactQP]]:
    for nodes in (31, 63):
        yield f"mesh {nodes}", cq.ContactQP(*bowl_on_triangles(nodes))
    for nodes in (50, 100, 200):
        yield f"beam {nodes}", cq.ContactQP(*beam_on_floor(nodes)[:2])
    for nodes in (15, 31):
        yield f"plate {nodes}", cq.ContactQP(*plate_over_bowl(nodes))
    rng = np.random.default_rng(0)
    for size in (5, 20, 80, 80, 300, 300):
        root = rng.normal(size=(size, size))
        matrix = root @ root.T + 10.0 ** rng.uniform(-2, 1) * np.eye(size)
        yield f"random {size}", cq.ContactQP((matrix + matrix.T) / 2, rng.normal(size=size))


def sharpness(
    problems: Iterable[tuple[str, cq.Membrane | cq.Cable | cq.ContactQP]],
    wanted: list[str],
    tolerances: tuple[float, ...],
) -> None:
    ratios: dict[tuple[str, str], list[float]] = {}
    print(f"{'problem':12s} {'backend':12s} {'tol':>6s} {'error':>8s} {'fast/error':>10s} {'sharp/error':>11s}")
    for name, model in problems:
        if wanted and name not in wanted:
            continue
        problem = model if isinstance(model, cq.ContactQP) else model.problem
        truth = cq.certify(problem, cq.solve(model, "active-set", tol=1e-12).gap)
        for backend in suitable_backends(problem):
            if backend == "mangasarian" and problem.size > LARGEST_LINEAR_PROGRAM:
                continue
            for tol in tolerances:
                gap = cq.solve(model, backend, tol=tol, on_failure="ignore").gap
                error = max(float((gap - truth.upper).max()), float((truth.lower - gap).max()), 0.0)
                known = max(ROUNDING * problem.gap_scale, float((truth.upper - truth.lower).max()))
                if error <= known:
                    print(f"{name:12s} {backend:12s} {tol:6.0e} as near as is known")
                    continue
                found = [cq.certify(problem, gap, effort=effort).gap_bound / error for effort in ("fast", "sharp")]
                print(f"{name:12s} {backend:12s} {tol:6.0e} {error:8.1e} {found[0]:10.1f} {found[1]:11.4f}")
                for effort, ratio in zip(("fast", "sharp"), found, strict=True):
                    ratios.setdefault((backend, effort), []).append(ratio)
                    ratios.setdefault(("all", effort), []).append(ratio)
    print(f"\n{'bound over true error':24s} {'median':>8s} {'largest':>8s}")
    for (backend, effort), found in sorted(ratios.items()):
        print(f"{backend:12s} {effort:11s} {np.median(found):8.3f} {max(found):8.3g}   ({len(found)} answers)")


def cost(sizes: list[int]) -> None:
    print(f"\n{'nodes':>8s} {'sweep':>9s} {'fast':>12s} {'sharp':>13s} {'memory of fast':>15s} {'of sharp':>9s}")
    for nodes in sizes:
        problem = cq.gallery.bowl(nodes).problem
        gap = cq.solve(problem, "multigrid", tol=1e-6).gap
        stencil = problem.stencil
        assert stencil is not None
        sweeper = LatticeSweeper(stencil, problem.layout, problem.q, gap, problem.bound_grids())
        sweep = least_seconds(lambda sweeper=sweeper: sweeper.sweep(1.0, 1))
        seconds, vectors = {}, {}
        for effort in ("fast", "sharp"):

            def run(effort: str = effort) -> None:
                cq.certify(problem, gap, effort=effort)  # noqa: B023

            seconds[effort], vectors[effort] = least_seconds(run), largest_memory(run) / gap.nbytes
        fast, sharp = seconds["fast"] / sweep, seconds["sharp"] / sweep
        print(
            f"{nodes**2:8d} {sweep * 1e3:6.2f} ms {fast:5.1f} sweeps {sharp:6.0f} sweeps "
            f"{vectors['fast']:7.1f} vectors {vectors['sharp']:9.1f}"
        )


def least_seconds(run: Callable[[], object], repeats: int = 25) -> float:
    """Return the least of several timings."""
    best = np.inf
    for _ in range(repeats):
        started = time.perf_counter()
        run()
        best = min(best, time.perf_counter() - started)
    return float(best)


def largest_memory(run: Callable[[], object]) -> int:
    """Return the bytes that a call holds at most, numpy's arrays included."""
    tracemalloc.start()
    run()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=["sharpness", "beyond", "cost", []], help="by default all")
    parser.add_argument("--problems", nargs="*", help="of the sharpness, by default all")
    parser.add_argument(
        "--sizes", type=int, nargs="*", default=[255, 511, 1023], help="of the cost: nodes along a side"
    )
    arguments = parser.parse_args()
    parts = arguments.parts or ["sharpness", "beyond", "cost"]
    warnings.simplefilter("ignore", cq.ContactWarning)
    if "sharpness" in parts:
        sharpness(problems(), arguments.problems or [], TOLERANCES)
    if "beyond" in parts:
        sharpness(matrices(), arguments.problems or [], TOLERANCES_BEYOND)
    if "cost" in parts:
        cost(arguments.sizes)


if __name__ == "__main__":
    main()
