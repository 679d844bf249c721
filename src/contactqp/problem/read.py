"""Problems read from files: those of `ContactProblem.write`, and quadratic programs of other people."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..foundation.loading import load_modules, needed
from ..foundation.quiet import output_discarded
from ..foundation.text import shortened
from .contact_lcp import ContactLCP
from .contact_qp import ContactQP
from .program_files import beside

_LEAST_ENTRY = 1e-12
"""HiGHS leaves out entries of less, and takes no smaller limit."""

_LONGEST = 1000
"""Characters of what is told of a file: an error of the problem's own says at its end what to do."""


def read(path: str | Path, *, kernel: ArrayLike | Literal["constant"] | None = None) -> ContactQP | ContactLCP:
    """Return the problem that a file holds.

    Parameters
    ----------
    path : str or Path
        ``.mps`` (with QUADOBJ) or ``.lp``, read by HiGHS: a quadratic program whose only constraints are bounds of its
        columns; HiGHS leaves out entries of less than 1e-12. ``.npz``: what `ContactProblem.write` wrote, or arrays
        ``data``, ``indices``, ``indptr`` of the rows of G, or ``G``, with ``q`` and, if they are not 0 and inf,
        ``lower`` and ``upper``. ``.mtx``: G in Matrix Market's format, with ``x_q.mtx`` and, where there are such
        files, ``x_lower.mtx``, ``x_upper.mtx`` and ``x_kernel.mtx`` beside ``x.mtx``.
    kernel : "constant" or array, optional
        As for `ContactQP`, where the file has none.

    Returns
    -------
    ContactQP, or ContactLCP
        The latter if the matrix is not symmetric. The problem's numbers are those of the file to the bit; what a
        lattice's matrix came from is not in it.

    Raises
    ------
    FileNotFoundError
        If there is no such file, or one that belongs to it is missing.
    ValueError
        If it is no file of its kind, or holds another kind of problem; the message names the file.
    ImportError
        If ``.mps`` or ``.lp`` is asked for and highspy is not installed.

    Examples
    --------
    >>> import tempfile
    >>> import contactqp as cq
    >>> problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    >>> file = problem.write(Path(tempfile.mkdtemp()) / "two.npz")
    >>> cq.read(file)
    ContactQP(2 unknowns, 4 nonzeros, M-matrix)
    """
    path = Path(path)
    reader = PROBLEM_READERS.get(path.suffix.lower())
    if reader is None:
        raise ValueError(f"{path}: unknown kind of problem {path.suffix!r}; known: {' '.join(PROBLEM_READERS)}")
    if not path.is_file():
        raise FileNotFoundError(f"there is no file {path}")
    try:
        parts = reader(path)
        if kernel is not None:
            parts["kernel"] = kernel
        return _posed(**parts)
    except OSError:
        raise
    except (ValueError, TypeError, KeyError) as error:
        raise ValueError(f"{path}: {shortened(error, _LONGEST)}") from None


def _posed(G: Any, q: Any, *, symmetric: bool = True, **others: Any) -> ContactQP | ContactLCP:
    return ContactQP(G, q, **others) if symmetric else ContactLCP(G, q, **others)


def _read_program(path: Path) -> dict[str, Any]:
    highspy = needed("highspy", f"reading {path.suffix} files", "highspy")
    load_modules("scipy.sparse")
    from scipy import sparse

    with output_discarded():  # HiGHS greets whoever makes it for the first time
        highs = highspy.Highs()
        highs.setOptionValue("output_flag", False)
        highs.setOptionValue("small_matrix_value", _LEAST_ENTRY)
        unread = highs.readModel(str(path)) == highspy.HighsStatus.kError
    if unread:
        raise ValueError("HiGHS cannot read it")
    model = highs.getModel()
    program, hessian = model.lp_, model.hessian_
    if program.num_row_:
        raise ValueError(
            f"it has {program.num_row_} rows of constraints; a contact problem has bounds of its columns only"
        )
    if any(kind != highspy.HighsVarType.kContinuous for kind in program.integrality_):
        raise ValueError("some of its columns are integers; those of a contact problem are real numbers")
    if program.sense_ != highspy.ObjSense.kMinimize:
        raise ValueError("it is to be maximised; a contact problem is a minimum")
    size = program.num_col_
    if hessian.dim_ != size:
        raise ValueError("it has no quadratic part: it is a linear program, and no contact problem")
    stored = np.array(hessian.value_), np.array(hessian.index_), np.array(hessian.start_)
    half = sparse.csc_array(stored, shape=(size, size))
    matrix = half + sparse.tril(half, -1).T
    return {"G": matrix, "q": program.col_cost_, "lower": program.col_lower_, "upper": program.col_upper_}


def _read_arrays(path: Path) -> dict[str, Any]:
    load_modules("scipy.sparse")
    from scipy import sparse

    try:
        with np.load(path, allow_pickle=False) as archive:
            parts = dict(archive)
    except Exception as error:  # of a damaged archive anything may be said
        raise ValueError(f"it is no file of arrays, or a damaged one: {error}") from None
    known = {"data", "indices", "indptr", "G", "q", "symmetric", "lower", "upper", "kernel", "gap_scale"}
    if "q" not in parts or not ("G" in parts or {"data", "indices", "indptr"} <= parts.keys()):
        found = ", ".join(parts) or "none"
        raise ValueError(f"it must hold q, and data, indices and indptr of the rows of G, or G; it holds {found}")
    rows = tuple(parts.pop(name, None) for name in ("data", "indices", "indptr"))
    if "G" not in parts:
        parts["G"] = sparse.csr_array(rows, shape=(parts["q"].size, parts["q"].size))
    if "symmetric" in parts:
        parts["symmetric"] = bool(parts["symmetric"])
    if "gap_scale" in parts:
        parts["gap_scale"] = float(parts["gap_scale"])
    return {name: values for name, values in parts.items() if name in known}


def _read_matrix_market(path: Path) -> dict[str, Any]:
    load_modules("scipy.io")
    from scipy import io, sparse

    forces = beside(path, "q")
    if not forces.is_file():
        raise FileNotFoundError(f"{path} holds a matrix, and there is no file {forces} with the forces")
    symmetric = io.mminfo(path)[-1] == "symmetric"
    parts: dict[str, Any] = {"G": sparse.csr_array(io.mmread(path)), "q": io.mmread(forces).ravel()}
    for name in ("lower", "upper"):
        if beside(path, name).is_file():
            parts[name] = io.mmread(beside(path, name)).ravel()
    if beside(path, "kernel").is_file():
        parts["kernel"] = io.mmread(beside(path, "kernel"))
    if not symmetric:
        matrix = parts["G"]
        parts["symmetric"] = bool((matrix != matrix.T).nnz == 0)
    return parts


PROBLEM_READERS: dict[str, Callable[[Path], dict[str, Any]]] = {
    ".mps": _read_program,
    ".lp": _read_program,
    ".npz": _read_arrays,
    ".mtx": _read_matrix_market,
}
"""What reads the parts of a problem, by the suffix of the file in small letters."""
