"""Solved by communicators of 1, 2, 3, 5 and 9 of the processes that mpiexec has started: bits and facts of each answer.

Written into a file as JSON: for each case and number of processes digests of all fields, row by row, and the facts.
"""

import hashlib
import json
import sys
import time
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np
from membranes_by_rows import CASES, SIZES
from mpi4py import MPI

import contactqp as cq


def digest(answer):
    """Return a digest of every field, of all processes' rows in their order."""
    fields = answer.gap, answer.deflection, answer.reaction, answer.contact_state, *answer.gap_bounds
    comm = answer.posed.ranks.comm
    found = {}
    for name, field in zip(("gap", "deflection", "reaction", "state", "lower", "upper"), fields, strict=True):
        whole = comm.gather(np.ascontiguousarray(field), root=0)
        if comm.rank == 0:
            found[name] = hashlib.sha256(np.concatenate(whole).tobytes()).hexdigest()
    return found


def facts(answer):
    """Return what all processes know of an answer."""
    balance = answer.force_balance
    numbers = [answer.gap_bound, answer.scale, *answer.total_reaction, *answer.contact_area, *answer.node_counts]
    numbers += [
        *answer.energy_bracket,
        balance.load,
        balance.reaction,
        balance.frame,
        balance.ceiling,
        answer.residuals.objective,
    ]
    return {
        "numbers": [float(number).hex() for number in numbers],
        "ended": f"{answer.status.value} {answer.termination}",
    }


def warm(name, comm, folder):
    """Return what is found from an earlier answer, from a store that one process wrote, and by a session."""
    membrane, asked = CASES[name](), {"tol": 1e-9, "least_rows": 16}
    loose = cq.mpi.solve(membrane, comm, tol=1e-5, least_rows=16)
    store = folder / f"{name}.zarr"
    if comm.size == 1:
        loose.to_zarr(store)
    answers = [cq.mpi.solve(membrane, comm, warm_start=start, **asked) for start in (loose, store)]
    session = cq.mpi.Solver(membrane, comm, **asked)
    answers += [session.solve_varied(membrane.with_load(factor)) for factor in (0.8, 0.9, 1.0)]
    return {
        "warm": [digest(answer) for answer in answers],
        "warm facts": [facts(answer) for answer in answers],
        "warm cycles": [answer.iterations for answer in answers],
    }


def refused(comm, folder):
    """Return the words by which each process refuses starts, of which one alone knows that they are no good."""
    membrane, told = CASES["masked"](), []
    for start in (folder / "woven.zarr", folder / "none.zarr", folder / "masked.zarr" if comm.rank else None, 3.0):
        try:
            cq.mpi.solve(membrane, comm, warm_start=start, least_rows=16)
        except (OSError, TypeError, ValueError) as error:
            told.append(f"{type(error).__name__} {error}")
    return comm.gather(told, root=0)


def beside_one_process(answer):
    """Return how far the answer of one process that holds all rows is from that of the backend multigrid."""
    membrane = answer.membrane
    nodes = membrane.nodes(0, membrane.shape[0])
    fields = {name: field for name, field in membrane.given.items() if name != "mask"}
    model = cq.Membrane(
        cq.Lattice.from_mask(nodes, membrane.spacing, membrane.origin),
        membrane.tension,
        **fields,
        upwards=membrane.upwards,
    )
    solution = cq.solve(model, "multigrid", tol=1e-9)
    lower, upper = (bound[nodes] for bound in answer.gap_bounds)
    outside = np.maximum(solution.certificate.lower - upper, lower - solution.certificate.upper).max()
    energies, known = cq.energy_bracket(model, solution.gap), answer.energy_bracket
    assert known.lower <= energies.upper
    assert energies.lower <= known.upper
    assert known.upper - known.lower < 1e-6 * abs(known.upper)
    assert max(answer.total_reaction.lower, solution.total_reaction.lower) <= min(
        answer.total_reaction.upper, solution.total_reaction.upper
    )
    assert abs(answer.max_slope - solution.max_slope) < 1e-12
    return {"apart": float(np.abs(answer.gap[nodes] - solution.gap).max()), "outside": max(0.0, float(outside))}


def traced(two, alone, folder):
    """Trace two loads by two processes, then three by one of them, which goes on after the stores that are there."""
    first = cq.mpi.trace(CASES["masked"](), [0.5, 1.0], folder, two, tol=1e-8, least_rows=16)
    if two.rank > 0:
        return {}
    (folder / "load-0001.zarr" / "zarr.json").unlink()  # as if it had been lost
    second = cq.mpi.trace(CASES["masked"](), [0.5, 1.0, 1.5], folder, alone, tol=1e-8, least_rows=16)
    return {
        0: {"resumed": [step.resumed for step in (*first, *second)]},
        1: {"same": [same_but_resumed(*pair) for pair in zip(first, second, strict=False)]},
        2: {"status": [step.status for step in second]},
        3: {"areas": [step.contact_area.lower for step in second]},
    }


def same_but_resumed(one, other):
    return replace(one, resumed=False) == replace(other, resumed=False)


def main(path):
    world, found = MPI.COMM_WORLD, defaultdict[str, dict[int, dict[str, object]]](dict)
    comms = {size: world.Split(0 if world.rank < size else 1, world.rank) for size in (1, 2, 3, 5, 9)}
    for size, comm in comms.items():
        for name in CASES if world.rank < size else ():
            if size not in SIZES[name]:
                continue
            answer = cq.mpi.solve(CASES[name](), comm, tol=1e-9, least_rows=16)
            digests, told = digest(answer), facts(answer) | {"cycles": answer.iterations}
            told |= warm(name, comm, Path(path).parent)
            if world.rank == 0:
                found[name][size] = {**digests, **told}
            if size == 1:
                found[name][1] |= beside_one_process(answer)
        rest_of_us = world.Ibarrier()
        while not rest_of_us.Test():
            time.sleep(0.01)  # who waits in MPI takes a core
    if world.rank < 2:
        found["trace"] |= traced(comms[2], comms[1], Path(path).parent / "loads")
        found["refused"][2] = {"words": refused(comms[2], Path(path).parent)}
    if world.rank == 0:
        with open(path, "w", encoding="utf-8") as file:
            json.dump(found, file)


if __name__ == "__main__":
    main(sys.argv[1])
