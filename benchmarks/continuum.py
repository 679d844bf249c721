"""What an answer on a lattice proves of the membrane at every point, against the spacing, and what that costs.

A flat floor below a unit square, T = p = 1, depth 0.03. The true error of the lattice's answer is taken against a
lattice of 1024² squares. Times are in units of a cold solve by multigrid to 1e-6 on the same lattice; the fastest of
several runs in turn is told.

    python benchmarks/continuum.py               print the table, up to 512² squares
    python benchmarks/continuum.py --finest 128  up to fewer
"""

import argparse

import numpy as np
from timing import in_turn

import contactqp as cq
from contactqp.continuum.data import Data
from contactqp.continuum.membrane import membrane_bounds
from contactqp.solving.resolved import Resolved
from contactqp.solving.solution import Solution

HEADS = "squares", "true error", "max(U - u)", "/ true", "max(u - L)", "/ true", "clear", "contact", "undecided", "time"


def bowl(squares):
    lattice = cq.Frame.rectangle(1, 1).lattice(1 / squares)
    return cq.Membrane(lattice, tension=1.0, load=1.0, support=0.03)


def row_of(squares, truth, finest, repeat):
    model = bowl(squares)
    solution = cq.solve(model, "multigrid", tol=1e-9, on_failure="ignore")
    every = finest // squares
    exact = truth.reshape(finest - 1, -1)[every - 1 :: every, every - 1 :: every].ravel()
    error = np.abs(solution.gap - exact).max()
    data, depths = Data.of(model), model.padded_below(solution.gap)

    def enclose():
        return membrane_bounds(data, depths, solution.gap, Resolved(model, solution.gap, Solution.by))

    found = enclose()
    above, below = (found.gap_upper - solution.gap).max(), (solution.gap - found.gap_lower).max()
    assert (found.gap_lower <= exact + 1e-9).all()
    assert (exact <= found.gap_upper + 1e-9).all()
    parts = [
        state.sum() / squares**2 for state in (found.contact.clear, found.contact.contact, found.contact.undecided)
    ]
    cold, pointwise = in_turn(repeat, lambda: cq.solve(model, "multigrid", tol=1e-6), enclose)
    return squares, error, above, above / error, below, below / error, *parts, pointwise / cold


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--finest", type=int, default=512, help="squares along a side, a power of two")
    parser.add_argument(
        "--truth", type=int, default=1024, help="squares along a side of the lattice that counts as true"
    )
    parser.add_argument("--repeat", type=int, default=3)
    chosen = parser.parse_args()
    truth = cq.solve(bowl(chosen.truth), "multigrid", tol=1e-9, on_failure="ignore").gap
    print("| " + " | ".join(HEADS) + " |")
    print("|" + "---|" * len(HEADS))
    squares = 16
    while squares <= chosen.finest:
        cells = row_of(squares, truth, chosen.truth, chosen.repeat)
        told = f"| {cells[0]}² | {cells[1]:.1e} | {cells[2]:.1e} | {cells[3]:.1f} | {cells[4]:.1e} | {cells[5]:.0f} | "
        print(told + " | ".join(f"{part:.3f}" for part in cells[6:9]) + f" | {cells[9]:.1f} |", flush=True)
        squares *= 2


if __name__ == "__main__":
    main()
