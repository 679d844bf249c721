"""Where PETSc is on this machine, and how a matrix gets there."""

from __future__ import annotations

import os
from collections.abc import Mapping
from glob import glob
from typing import Any

from ..methods.factors import DIRECT_SIZE
from ..problem.contact_problem import ContactProblem
from . import petsc_worker
from .in_files import InFiles
from .interpreters import Interpreter, interpreter_with
from .processes import Lost, LostProcessError, Placed

VARIABLE = "CONTACTQP_PETSC_PYTHON"
"""The environment variable that may name an interpreter with petsc4py."""

INSTALL = (
    "apt install python3-petsc4py (Debian, Ubuntu), or conda install -c conda-forge petsc4py, or build PETSc from "
    f"source; an interpreter elsewhere that has it is named by the environment variable {VARIABLE}"
)


def interpreter() -> Interpreter | None:
    """Return the interpreter that has petsc4py: Debian's finds it in none of its folders but by a variable."""
    builds = () if "PETSC_DIR" in os.environ else sorted(glob("/usr/lib/petscdir/*/*-real"), reverse=True)
    return interpreter_with("petsc4py.PETSc", VARIABLE, [{"PETSC_DIR": build} for build in builds])


def options(problem: ContactProblem, ranks: int) -> dict[str, Any]:
    """Return PETSc's options as the package sets them.

    Few unknowns are factorised; of more, multigrid has every other node of a lattice, or what GAMG finds in a matrix.
    """
    few, many = "lu" if ranks == 1 else "redundant", "gamg" if problem.stencil is None else "mg"
    kind = few if problem.size <= DIRECT_SIZE else many
    return {"ksp_type": "cg", "snes_vi_zero_tolerance": 0.0, "pc_type": kind}


def placed(problem: ContactProblem, ranks: int, told: Mapping[str, Any]) -> Placed:
    """Return a problem's matrix in PETSc, see `contactqp.backends.petsc_worker.System`: always in a process of its own.

    Parameters
    ----------
    problem : ContactProblem
    ranks : int
        Processes that share it.
    told : mapping of str to object
        PETSc's options, by name.
    """
    found, matrix, stencil = interpreter(), problem.G.tocsr(), problem.stencil
    arrays = {name: getattr(matrix, name) for name in ("indptr", "indices", "data")}
    if stencil is not None:
        arrays["mask"] = stencil.mask
    if found is None:
        return Lost(LostProcessError("no interpreter has petsc4py any more"))
    try:
        return InFiles(found, petsc_worker.__file__, ranks, arrays, {"options": told})
    except LostProcessError as error:
        return Lost(error)
