"""Files of problems: MPS and LP for programs of other people, arrays of numpy, and Matrix Market."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.checks import Vector
from ..foundation.files import replaced_as_a_whole, require_writable
from ..foundation.loading import load_modules

if TYPE_CHECKING:
    from .posed import Posed

PROGRAMS = (".mps", ".lp")
"""Suffixes of formats that hold a function to be minimised."""

BESIDE = ("q", "lower", "upper", "kernel")
"""What a file of Matrix Market, which holds one matrix, leaves to files beside it: ``x_q.mtx`` and so on."""


def write_problem(problem: Posed, path: Path, gap_scale: float) -> Path:
    """Write a problem into a file of the format that its suffix names; see `ContactProblem.write`."""
    require_writable(path, tuple(PROBLEM_WRITERS), "problem")
    PROBLEM_WRITERS[path.suffix.lower()](problem, path, gap_scale)
    return path


def beside(path: Path, name: str) -> Path:
    """Return the file of Matrix Market that holds another part of the problem whose matrix is in ``path``.

    Examples
    --------
    >>> beside(Path("bridge.mtx"), "q").name
    'bridge_q.mtx'
    """
    return path.with_name(f"{path.stem}_{name}{path.suffix}")


def _write_mps(problem: Posed, path: Path, gap_scale: float) -> None:
    """Write the quadratic program in free MPS, every column with its cost, which HiGHS leaves out where it is zero.

    Programs number columns as they meet them, so that an answer would come back in another order.
    """
    row, column, values = _lower_triangle(problem)
    lines = ["NAME contactqp", "ROWS", " N obj", "COLUMNS"]
    lines += [f" c{k} obj {_digits(cost)}" for k, cost in enumerate(problem.q)]
    lines += ["RHS", "BOUNDS"]
    for k, (low, high) in enumerate(zip(problem.lower, problem.upper, strict=True)):
        if low == -np.inf:
            lines.append(f" {'FR' if high == np.inf else 'MI'} bound c{k}")
        elif low != 0 or high != np.inf:
            lines.append(f" LO bound c{k} {_digits(low)}")
        if high != np.inf:
            lines.append(f" UP bound c{k} {_digits(high)}")
    lines.append("QUADOBJ")
    lines += [f" c{j} c{i} {_digits(value)}" for i, j, value in zip(row, column, values, strict=True)]
    _write_lines([*lines, "ENDATA"], path)


def _write_lp(problem: Posed, path: Path, gap_scale: float) -> None:
    """Write the quadratic program in the LP format, one term a line, every column with its cost as in MPS."""
    row, column, values = _lower_triangle(problem)
    lines = ["minimize", " obj:"]
    lines += [f"  {_signed(cost)} c{k}" for k, cost in enumerate(problem.q)]
    lines.append("  + [")
    # Half of what stands between the brackets counts: an entry beside the diagonal stands for two.
    lines += [
        f"  {_signed(value)} c{i} ^ 2" if i == j else f"  {_signed(2 * value)} c{j} * c{i}"
        for i, j, value in zip(row, column, values, strict=True)
    ]
    lines += ["  ] / 2", "subject to", "bounds"]
    for k, (low, high) in enumerate(zip(problem.lower, problem.upper, strict=True)):
        if low == -np.inf and high == np.inf:
            lines.append(f" c{k} free")
        elif low != 0 or high != np.inf:
            lines.append(f" {_digits(low)} <= c{k}" + ("" if high == np.inf else f" <= {_digits(high)}"))
    _write_lines([*lines, "end"], path)


def _lower_triangle(problem: Posed) -> tuple[Any, Any, Any]:
    load_modules("scipy.sparse")
    from scipy import sparse

    triangle = sparse.coo_array(sparse.tril(problem.G))
    return triangle.row, triangle.col, triangle.data


def _digits(value: float) -> str:
    """Return a number with as many digits as tell it from every other one."""
    return repr(float(value))


def _signed(value: float) -> str:
    return f"{'-' if value < 0 else '+'} {_digits(abs(value))}"


def _write_lines(lines: list[str], path: Path) -> None:
    with replaced_as_a_whole(path) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="ascii")


def _write_arrays(problem: Posed, path: Path, gap_scale: float) -> None:
    """Write what the matrix consists of, forces, bounds, kernel and gap scale as arrays by name."""
    with replaced_as_a_whole(path) as unfinished, unfinished.open("wb") as stream:
        np.savez_compressed(stream, allow_pickle=False, **arrays_of(problem, gap_scale))


def _write_matrix_market(problem: Posed, path: Path, gap_scale: float) -> None:
    """Write the matrix, and vectors into files beside it; those that an earlier problem left are removed."""
    load_modules("scipy.io")
    from scipy import io, sparse

    kept = _vectors(problem)
    if problem.bounds.standard and problem.supported.all():
        del kept["lower"], kept["upper"]
    elif problem.one_sided:
        del kept["upper"]
    symmetry = "symmetric" if problem.symmetric else "general"
    matrix = sparse.coo_array(problem.G)
    for file, values in [(path, matrix), *((beside(path, name), values) for name, values in kept.items())]:
        with replaced_as_a_whole(file) as unfinished, unfinished.open("wb") as stream:
            columns = values if values.ndim == 2 else values[:, None]
            io.mmwrite(stream, columns, symmetry=symmetry if file is path else "general")
    for name in BESIDE:
        if name not in kept:
            beside(path, name).unlink(missing_ok=True)


def arrays_of(problem: Posed, gap_scale: float) -> dict[str, Any]:
    """Return what the matrix consists of, forces, bounds, kernel and gap scale by their names in ``.npz`` files."""
    matrix = problem.G
    parts = {"data": matrix.data, "indices": matrix.indices, "indptr": matrix.indptr, "symmetric": problem.symmetric}
    return parts | _vectors(problem) | {"gap_scale": gap_scale}


def _vectors(problem: Posed) -> dict[str, Vector]:
    vectors = {"q": problem.q, "lower": np.array(problem.lower), "upper": np.array(problem.upper)}
    if problem.kernel is not None:
        vectors["kernel"] = problem.kernel.vectors
    return vectors


PROBLEM_WRITERS: dict[str, Callable[[Posed, Path, float], None]] = {
    ".mps": _write_mps,
    ".lp": _write_lp,
    ".npz": _write_arrays,
    ".mtx": _write_matrix_market,
}
"""What writes a problem, by the suffix of the file in small letters; what reads it stands in `read`."""
