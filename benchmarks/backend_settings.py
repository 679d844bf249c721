"""Trial of the general backends' settings: which of those that certify is the fastest.

    python benchmarks/backend_settings.py [--sizes 63 127 255] [--tol 1e-6] > benchmarks/backend_settings.txt

Prints a table for the hexagon and for the bowl on the unit square at each size: the seconds of every variant of
settings over those of the default, all measured in this process, one after the other, with the time of each the least
of ``--repeat`` runs. A variant that does not certify is marked.
"""

from __future__ import annotations

import argparse

import contactqp as cq
from contactqp.gallery import bowl, paper_hexagon

VARIANTS: dict[str, list[dict[str, object]]] = {
    "osqp": [
        {},
        *({"rho": rho} for rho in (0.01, 0.03, 0.1, 1.0, 10.0)),
        *({"alpha": alpha} for alpha in (1.0, 1.6, 1.9)),
        {"polishing": False},
        {"polishing": False, "rho": 0.1, "alpha": 1.6, "eps": 1e-6},
        {"scaling": 0},
        {"adaptive_rho": False},
        {"check_termination": 10},
        {"check_termination": 100},
        {"eps": 1e-6},
        {"eps": 1e-8},
    ],
    "clarabel": [
        {},
        {"direct_solve_method": "faer"},
        {"equilibrate_enable": False},
        {"static_regularization_constant": 1e-7},
        {"static_regularization_constant": 1e-8},
        {"static_regularization_constant": 1e-10},
        {"eps": 1e-12},
        {"eps": 1e-13},
        {"eps": 1e-14},
        {"eps": 1e-15},
        {"eps": 1e-16},
    ],
    "mangasarian": [
        {},
        {"method": "highs-ipm"},
        {"presolve": True},
        {"cost": "barrier"},
        {"cost": "stiffness of the barrier"},
        {"cost": "random"},
        {"eps": 1e-7},
    ],
}
LARGEST = {"mangasarian": 63 * 63}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="*", default=[63, 127])
    parser.add_argument("--tol", type=float, default=1e-6)
    parser.add_argument("--time-limit", type=float, default=20.0, help="seconds a solve")
    parser.add_argument("--repeat", type=int, default=2)
    parser.add_argument("--backends", nargs="*", default=list(VARIANTS))
    arguments = parser.parse_args()
    problems = {"hexagon": paper_hexagon()} | {f"bowl {n}x{n}": bowl(n) for n in arguments.sizes}
    for backend in arguments.backends:
        print(f"\n{backend}, tol {arguments.tol:g}")
        figures = f"{'iterations':>10s} {'bound':>8s} {'seconds':>8s} {'/default':>8s}"
        print(f"{'problem':14s} {'settings':42s} {'status':16s} {figures}")
        for name, model in problems.items():
            if model.lattice.size > LARGEST.get(backend, 10**9):
                continue
            cq.solve(model, backend, tol=0.1, on_failure="ignore")  # so that no variant pays for loading the library
            reference = None
            for variant in VARIANTS[backend]:
                options = resolve(variant, model)
                best = None
                for _ in range(arguments.repeat):
                    solution = cq.solve(
                        model,
                        backend,
                        tol=arguments.tol,
                        time_limit=arguments.time_limit,
                        on_failure="ignore",
                        **options,
                    )
                    if best is None or solution.seconds < best.seconds:
                        best = solution
                assert best is not None
                reference = reference or best.seconds
                label = ", ".join(f"{key}={value}" for key, value in variant.items()) or "(default)"
                print(
                    f"{name:14s} {label:42s} {best.status.value:16s} {best.iterations:10d} {best.relative_bound:8.1e} "
                    f"{best.seconds:8.3f} {best.seconds / reference:8.2f}",
                    flush=True,
                )


def resolve(variant: dict[str, object], model: cq.Membrane) -> dict[str, object]:
    """Replace the name of a cost vector by the vector."""
    import numpy as np

    barrier = model.problem.barrier
    assert barrier is not None
    costs = {
        "barrier": barrier.v,
        "stiffness of the barrier": barrier.s,
        "random": np.random.default_rng(0).uniform(0.5, 2.0, model.lattice.size),
    }
    return {key: costs[str(value)] if key == "cost" else value for key, value in variant.items()}


if __name__ == "__main__":
    main()
