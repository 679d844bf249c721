"""Random contact problems, and an independent solution of small ones."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import product

import numpy as np
from hypothesis import strategies as st

import contactqp as cq
from contactqp.backends import TABLE
from contactqp.proof.judge import Verdict
from contactqp.solving.solution import Run

BACKENDS = tuple(name for name in TABLE if not name.endswith(":"))


@st.composite
def m_matrices(draw, min_size=1, max_size=8, spread=1.0):
    """Symmetric M-matrices: Laplacians of random graphs plus positive diagonals, with scales apart by 10**±spread."""
    size = draw(st.integers(min_size, max_size))
    seed = draw(st.integers(0, 2**32 - 1))
    density = draw(st.floats(0.0, 1.0))
    rng = np.random.default_rng(seed)
    weights = np.triu(rng.uniform(0.05, 1.0, (size, size)) * (rng.uniform(size=(size, size)) < density), 1)
    weights = weights + weights.T
    ground = rng.uniform(0.05, 1.0, size)
    scale = 10.0 ** rng.uniform(-spread / 2, spread / 2, size)
    matrix = np.diag(weights.sum(axis=1) + ground) - weights
    matrix = scale[:, None] * matrix * scale[None, :]
    return (matrix + matrix.T) / 2


@st.composite
def problems(draw, min_size=1, max_size=8, spread=1.0):
    """Contact problems with a random M-matrix, forces of either sign, and sometimes nodes without a support."""
    matrix = draw(m_matrices(min_size, max_size, spread))
    size = len(matrix)
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    q = rng.normal(size=size) * np.sqrt(np.diag(matrix))
    free = draw(st.booleans())
    supported = rng.uniform(size=size) < 0.7 if free else None
    return cq.ContactQP(matrix, q, supported=supported)


@st.composite
def lattice_masks(draw, max_rows=6, max_columns=6):
    rows, columns = draw(st.integers(1, max_rows)), draw(st.integers(1, max_columns))
    seed, density = draw(st.integers(0, 2**32 - 1)), draw(st.floats(0.3, 1.0))
    mask = np.random.default_rng(seed).uniform(size=(rows, columns)) < density
    mask[rows // 2, columns // 2] = True
    return mask


def enumerate_solution(problem: cq.ContactQP) -> np.ndarray:
    """Return the exact solution by trying every contact set: none of the package's methods is used."""
    matrix, q, lower, upper = problem.G.toarray(), problem.q, problem.lower, problem.upper
    choices = [
        tuple(state for state, bound in ((0, 0.0), (-1, low), (1, high)) if np.isfinite(bound))
        for low, high in zip(lower, upper, strict=True)
    ]
    best, best_violation = None, np.inf
    for pattern in product(*choices):
        state = np.array(pattern)
        free = state == 0
        gap = np.where(state < 0, lower, np.where(state > 0, upper, 0.0))
        if free.any():
            gap[free] = np.linalg.solve(matrix[np.ix_(free, free)], -(q + matrix @ gap)[free])
        pressure = -state * (matrix @ gap + q) / np.diag(matrix)
        outside = np.maximum(lower - gap, gap - upper)[free]
        violation = max(0.0, np.max(outside, initial=0.0), -np.min(pressure, initial=0.0))
        if violation < best_violation:
            best, best_violation = gap, violation
    assert best is not None
    return best


def touching_softly(nodes: int, factor: float) -> cq.Membrane:
    """Return a membrane whose support follows the free deflection and is left with the fourth power of the radius."""
    lattice = cq.Frame.rectangle(1.0, 1.0, center=(0.5, 0.5)).lattice(spacing=1 / (nodes + 1))
    free = cq.solve(cq.Membrane(lattice, 1.0, load=4.0, support=np.inf), "multigrid", tol=1e-11).deflection
    square = (lattice.node_x - 0.5) ** 2 + (lattice.node_y - 0.5) ** 2
    return cq.Membrane(lattice, 1.0, load=4.0, support=lattice.scatter(free + factor * (square**2 - 1e-4), fill=1.0))


def altered(solution: cq.Solution, **changes: object) -> cq.Solution:
    """Return a copy of a solution with other facts of its run or its verdict, or another tolerance."""
    parts = {
        name: {field.name: changes.pop(field.name) for field in fields(kind) if field.name in changes}
        for name, kind in (("run", Run), ("verdict", Verdict))
    }
    request = solution.request
    if "tol" in changes:
        request = replace(request, tolerance=replace(request.tolerance, tol=changes.pop("tol")))
    assert not changes, changes
    run, verdict = replace(solution.run, **parts["run"]), replace(solution.verdict, **parts["verdict"])
    return replace(solution, request=request, run=run, verdict=verdict)


@st.composite
def bounds(draw, size):
    """Lower and upper bounds of every kind: none, one, both, equal ones."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    kind = rng.integers(0, 5, size)
    lower = np.where(np.isin(kind, (1, 3, 4)), rng.choice([0.0, 1.0], size) * rng.normal(size=size), -np.inf)
    width = np.where(kind == 4, rng.choice([0.0, 1e-9], size), rng.uniform(0.1, 2.0, size))
    upper = np.where(np.isin(kind, (3, 4)), lower + width, np.where(kind == 2, rng.normal(size=size), np.inf))
    return lower, upper
