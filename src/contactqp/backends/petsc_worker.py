"""PETSc's side of the backend ``petsc``: a matrix in PETSc, and what SNESVI finds with it.

An interpreter that has petsc4py runs this file, in one process or as the ranks of one MPI program: it imports numpy and
petsc4py alone, and old ones will do (Python 3.10, numpy 1.20). What it is asked, and what it answers, stands in files,
see `contactqp.backends.in_files`.
"""

from __future__ import annotations

import ctypes
import json
import os
import shutil
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

METHOD = "vinewtonrsls"
"""SNESVI's reduced-space method: Newton steps for the unknowns that are free (Benson and Munson 2006)."""

_TIME, _OFTEN, _SELDOM, _SOON = "time limit", 0.001, 0.02, 0.5

_ROUGH, _FEW = 1e-6, 50
"""How far the residual of a coarser problem is to fall, and the limit of its steps: it is but a start."""

_CLOSE = {"pc_gamg_aggressive_coarsening": 0, "pc_gamg_square_graph": 0, "pc_gamg_agg_nsmooths": 2}
"""Coarser problems for a start are closer to the finer ones than those of a preconditioner, or the contact set is off.

The first two are names of one option, in releases after each other.
"""

_COARSEST = 500
"""Unknowns that are factorised, and need no coarser ones."""

_INFINITE = 1e300
"""What counts as no bound: PETSc's own infinity is less than that of floating-point numbers."""


_PARENT = os.getppid()
"""Who has started this process: the caller, or mpiexec."""


class _Left(Exception):  # noqa: N818  (a finding, not a fault)
    """The time is over."""


class System:
    """A matrix in PETSc, its rows dealt out to the ranks, and the gap that the next solve starts from.

    Parameters
    ----------
    matrix : mapping of str to array
        "indptr", "indices" and "data" of all rows of a symmetric matrix; of a lattice also "mask", shape (rows,
        columns), true at the nodes, which are numbered row by row.
    options : mapping of str to object
        PETSc's options by name, without a dash, which are in its database.
    """

    def __init__(self, matrix: Mapping[str, Any], options: Mapping[str, Any]) -> None:
        from petsc4py import PETSc

        if np.dtype(PETSc.ScalarType).kind == "c":
            raise TypeError("this PETSc calculates with complex numbers; take one that is built for real ones")
        self._petsc, self._options = PETSc, dict(options)
        self.comm = PETSc.COMM_WORLD
        self.ranks, self.rank = self.comm.getSize(), self.comm.getRank()
        size = len(matrix["indptr"]) - 1
        share, more = divmod(size, self.ranks)
        first = self.rank * share + min(self.rank, more)
        self.mine = slice(first, first + share + (self.rank < more))
        rows = np.asarray(matrix["indptr"][first : self.mine.stop + 1])
        part = slice(int(rows[0]), int(rows[-1]))
        numbers = (np.array(given, dtype=PETSc.IntType) for given in (rows - rows[0], matrix["indices"][part]))
        csr = (*numbers, np.array(matrix["data"][part]))
        local = self.mine.stop - first, size
        self.program = _Program(PETSc.Mat().createAIJ((local, local), csr=csr, comm=self.comm))
        self._share = PETSc.Vec().createMPI((1, self.ranks), comm=self.comm)
        self._levels = self._levels_of(matrix.get("mask"))
        self._renewed = None if self._levels is None else _Renewed(self, self._levels)
        self._fresh = True

    def start(self, vectors: Mapping[str, Any], _told: Mapping[str, Any]) -> tuple[None, dict[str, Any]]:
        """Start the next solve from a gap, ``vectors["gap"]``, shape (n,), or where there is none, as the first."""
        self.program.gap.set(0.0)
        self._fresh = "gap" not in vectors
        if not self._fresh:
            self.program.gap.setArray(vectors["gap"][self.mine])
        return None, {}

    def solve(self, vectors: Mapping[str, Any], told: Mapping[str, Any]) -> tuple[Any, dict[str, Any]]:
        """Go on from the last gap.

        Parameters
        ----------
        vectors : mapping of str to array, shape (n,)
            "q", "l" and "u": the forces and the bounds.
        told : mapping of str to object
            "steps", the limit of steps; "seconds", that of time, or None; "eps", how far the residual is to fall, of
            the forces, both in the Euclidean norm, or None for PETSc's own tolerances; "coarse", whether to begin
            with coarser problems; "history", whether to record the steps.

        Returns
        -------
        gap : array
            This rank's share.
        facts : dict
            "word", "steps", "unused", the options that nothing has asked for, and "history": of each step the nodes
            that are "active" and have "changed" sides, and the norm of the "residual".
        """
        infinity, program, log = float(self._petsc.INFINITY), self.program, _Log(self, told)
        for vector, name in ((program.forces, "q"), (program.lower, "l"), (program.upper, "u")):
            vector.setArray(np.clip(vectors[name][self.mine], -infinity, infinity))
        word = _TIME
        try:
            if self._fresh and told["coarse"]:
                self._start_coarse(log)
            word = self._found(program, log.step, told["eps"], told["steps"])
        except Exception:
            if not log.left:
                raise
        self._fresh = False
        # Before the first step is over, not all has been set up that may ask for an option.
        unused = self._unused() if log.steps else []
        facts = {"word": word, "steps": log.steps, "unused": unused, "history": log.history}
        return np.array(program.gap.getArray()), facts

    def total(self, value: float) -> float:
        """Return the sum of a number over all ranks."""
        if self.ranks == 1:
            return value
        self._share.setArray(np.array([value], dtype=float))
        return float(self._share.sum())

    def _found(self, program: _Program, monitor: Callable[..., None], eps: float | None, steps: int) -> str:
        """Solve a program from its gap, and return PETSc's word for the end."""
        snes = self._petsc.SNES().create(self.comm)
        snes.setType(METHOD)
        snes.setFunction(program.residual, program.product)
        snes.setJacobian(lambda *_: None, program.matrix)  # it is always the same
        snes.setVariableBounds(program.lower, program.upper)
        snes.setTolerances(max_it=steps)
        if eps is not None:
            snes.setTolerances(rtol=0.0, atol=eps * program.forces.norm(), stol=0.0)
        snes.setMonitor(monitor)
        if self._renewed is not None:
            snes.getKSP().getPC().setType("python")
            self._renewed.serve(program, snes)
            snes.getKSP().getPC().setPythonContext(self._renewed)
        snes.setFromOptions()
        try:
            snes.solve(None, program.gap)
            reason, reasons = snes.getConvergedReason(), self._petsc.SNES.ConvergedReason
        finally:
            snes.destroy()
        return next((name for name, number in vars(reasons).items() if number == reason), f"reason {reason}")

    def _unused(self) -> list[str]:
        """Return the options that nothing has asked for so far; of PETSc's own functions petsc4py has none for that."""
        try:
            answer = ctypes.CDLL(self._petsc.__file__).PetscOptionsUsed
        except AttributeError:  # hidden, where PETSc is linked into petsc4py
            return []
        used = ctypes.c_int()

        def asked_for(name: str) -> bool:
            failed = answer(None, name.encode(), ctypes.byref(used))
            return bool(failed or used.value)

        return [name for name in self._options if not asked_for(name)]

    def _levels_of(self, mask: Any) -> _Algebraic | _Geometric | None:
        """Return the multigrid that the options ask for, which is not left to PETSc; None for all else."""
        wanted = self._options.get("pc_type")
        if wanted == "gamg":
            levels: _Algebraic | _Geometric = _Algebraic(self._petsc, self._options)
        elif wanted == "mg" and mask is not None:
            levels = _Geometric(self._petsc, mask, self.mine)
        else:
            return None
        # Set anew for each step, see `_Renewed`.
        del self._options["pc_type"]
        self._petsc.Options().delValue("pc_type")
        return levels

    def _start_coarse(self, log: _Log) -> None:
        """Start from the solution of coarser problems, each from the next coarser one's.

        From zero the contact set would move by a layer of nodes in each step.
        """
        if self._levels is None:
            return
        programs = [self.program, *self._levels.coarser(self.program)]
        for coarse, finer in zip(programs[:0:-1], programs[-2::-1], strict=True):
            self._found(coarse, log.look, _ROUGH, _FEW)
            coarse.interpolation.mult(coarse.gap, finer.gap)
            finer.project()


class _Program:
    """A program: the matrix, the vectors, and the gap that is sought.

    Parameters
    ----------
    matrix : Mat
    interpolation : Mat, optional
        Of a coarser program: P, which makes finer gaps of its own.
    scales : array, optional
        The unknowns of the matrix that PETSc has are these times the gaps.
    depth : int
        How many times coarser than the first it is.
    """

    def __init__(self, matrix: Any, interpolation: Any = None, scales: Any = 1.0, depth: int = 0) -> None:
        self.matrix, self.interpolation, self._scales, self.depth = matrix, interpolation, scales, depth
        matrix.setOption(matrix.Option.SPD, True)
        vectors = (matrix.createVecRight() for _ in range(5))
        self.gap, self.forces, self.lower, self.upper, self.product = vectors

    def residual(self, _snes: Any, gap: Any, residual: Any) -> None:
        """Calculate Gω + q."""
        self.matrix.multAdd(gap, self.forces, residual)

    def project(self) -> None:
        """Move the gap between the bounds."""
        self.gap.setArray(np.clip(self.gap.getArray(), self.lower.getArray(), self.upper.getArray()))

    def coarser(self, interpolation: Any, matrix: Any) -> _Program:
        """Return the program for the gaps Pω of coarse unknowns ω, whose bounds are means of those here.

        Parameters
        ----------
        interpolation : Mat
            P, which makes ones of ones, or nearly so.
        matrix : Mat
            PᵀGP.
        """
        found = _Program(matrix, interpolation, depth=self.depth + 1)
        weights, absent = found.gap.duplicate(), found.gap.duplicate()
        interpolation.multTranspose(self.forces, found.forces)
        interpolation.multTranspose(self._vector(1.0), weights)
        sums = np.abs(weights.getArray()) + np.finfo(float).tiny
        for own, mean, infinity in ((self.lower, found.lower, -np.inf), (self.upper, found.upper, np.inf)):
            bounds = np.array(own.getArray())
            without = np.abs(bounds) >= _INFINITE
            interpolation.multTranspose(self._vector(without), absent)
            interpolation.multTranspose(self._vector(np.where(without, 0.0, bounds)), mean)
            mean.setArray(np.where(absent.getArray() != 0.0, infinity, mean.getArray() / sums))
        found.project()
        return found

    def evenly_coarser(self, interpolation: Any, matrix: Any) -> _Program:
        """Return the program for coarse unknowns as PETSc has them, but scaled such that P makes ones of ones.

        PETSc's are as large as its factors leave them, and of either sign.
        """
        finer, product = self._vector(1.0 / self._scales), self.product
        interpolation = interpolation.copy()
        interpolation.diagonalScale(L=finer)
        ones, weights, coarse = self._vector(1.0), interpolation.createVecRight(), interpolation.createVecRight()
        interpolation.multTranspose(ones, weights)
        interpolation.mult(weights, product)
        interpolation.multTranspose(product, coarse)
        sums, squares = np.array(weights.getArray()), np.array(coarse.getArray())
        scales = np.divide(sums * sums, squares, out=np.ones_like(sums), where=squares != 0.0)
        coarse.setArray(scales)
        interpolation.diagonalScale(R=coarse)
        matrix = matrix.copy()
        matrix.diagonalScale(coarse, coarse)
        found = self.coarser(interpolation, matrix)
        found._scales = scales
        return found

    def _vector(self, values: Any) -> Any:
        """Return a vector of this size, whose share here has values."""
        found = self.gap.duplicate()
        found.setArray(np.broadcast_to(np.asarray(values, dtype=float), found.getLocalSize()))
        return found


class _Algebraic:
    """PETSc's algebraic multigrid (GAMG), which finds coarse unknowns by the matrix alone.

    Parameters
    ----------
    petsc : module
    options : mapping of str to object
        PETSc's options that are in its database.
    """

    def __init__(self, petsc: Any, options: Mapping[str, Any]) -> None:
        self._petsc = petsc
        self._close = {name: value for name, value in _CLOSE.items() if name not in options}

    def preconditioner(self, _program: _Program, matrix: Any, _free: Any) -> Any:
        """Return a preconditioner for the free rows and columns of a program's matrix, which are ``matrix``."""
        found = self._petsc.PC().create(matrix.getComm())
        found.setOperators(matrix)
        found.setType("gamg")
        found.setFromOptions()
        found.setUp()
        return found

    def coarser(self, program: _Program) -> list[_Program]:
        """Return coarser and coarser programs, of which the last has few unknowns."""
        database, found = self._petsc.Options(), list[_Program]()
        for name, value in self._close.items():
            database.setValue(name, value)
        levels = self.preconditioner(program, program.matrix, None)
        for name in self._close:
            database.delValue(name)
        for level in range(levels.getMGLevels() - 1, 0, -1):
            operator = levels.getMGSmoother(level - 1).getOperators()[0]
            program = program.evenly_coarser(levels.getMGInterpolation(level), operator)
            found.append(program)
        levels.destroy()
        return found


class _Geometric:
    """PETSc's multigrid (PCMG) on a lattice: every other node of every other row, and linear interpolation.

    Coarse functions are cut off where a bound holds the gap (Gräser and Kornhuber, *Multigrid methods for obstacle
    problems*, Journal of Computational Mathematics 27, 2009): P has the rows of the free nodes alone, and the
    columns of the coarse nodes about them, and coarse matrices are PᵀGP.

    Parameters
    ----------
    petsc : module
    mask : array of bool, shape (rows, columns)
        True = node; they are numbered row by row.
    mine : slice
        The nodes that this rank has.
    """

    def __init__(self, petsc: Any, mask: Any, mine: slice) -> None:
        self._petsc, self._interpolations = petsc, list[Any]()
        mask = np.asarray(mask)
        while np.count_nonzero(mask) > _COARSEST:
            part, coarse, of_coarse = _interpolation(mask, mine)
            sizes = tuple(
                (own.stop - own.start, int(np.count_nonzero(of))) for own, of in ((mine, mask), (of_coarse, coarse))
            )
            if sizes[1][1] == 0:
                break
            csr = (*(np.array(numbers, dtype=petsc.IntType) for numbers in part[:2]), part[2])
            self._interpolations.append(petsc.Mat().createAIJ(sizes, csr=csr, comm=petsc.COMM_WORLD))
            mask, mine = coarse, of_coarse

    def preconditioner(self, program: _Program, matrix: Any, free: Any) -> Any:
        """Return a preconditioner for the ``free`` rows and columns of a program's matrix, which are ``matrix``."""
        found, matrices, interpolations = self._petsc.PC().create(matrix.getComm()), [matrix], list[Any]()
        found.setOperators(matrix)
        for whole in self._interpolations[program.depth :]:
            interpolation, free = self._cut_off(whole, free)
            if free.getSize() == 0:
                break
            interpolations.append(interpolation)
            matrices.append(matrices[-1].ptap(interpolation))
        found.setType("mg")
        found.setMGLevels(len(matrices))
        for level, operator in enumerate(reversed(matrices)):
            solver = found.getMGSmoother(level) if level else found.getMGCoarseSolve()
            solver.setOperators(operator)
            if level:
                found.setMGInterpolation(level, interpolations[len(interpolations) - level])
                solver.setType("richardson")
                solver.setTolerances(max_it=1)
                solver.getPC().setType("sor")
        found.setFromOptions()
        found.setUp()
        return found

    def coarser(self, program: _Program) -> list[_Program]:
        """Return coarser and coarser programs, of which the last has few unknowns."""
        found = list[_Program]()
        for interpolation in self._interpolations:
            program = program.coarser(interpolation, program.matrix.ptap(interpolation))
            found.append(program)
        return found

    def _cut_off(self, interpolation: Any, free: Any) -> tuple[Any, Any]:
        """Return an interpolation's rows for free nodes, without columns of zeros, and which columns are left."""
        rows, weights = interpolation.createVecLeft(), interpolation.createVecRight()
        first = interpolation.getOwnershipRange()[0]
        values = np.zeros(rows.getLocalSize())
        values[free.getIndices() - first] = 1.0
        rows.setArray(values)
        interpolation.multTranspose(rows, weights)
        numbers = np.flatnonzero(weights.getArray()) + interpolation.getOwnershipRangeColumn()[0]
        left = self._petsc.IS().createGeneral(numbers.astype(self._petsc.IntType), comm=interpolation.getComm())
        return interpolation.createSubMatrix(free, left), left


def _interpolation(mask: Any, mine: slice) -> tuple[tuple[Any, Any, Any], Any, slice]:
    """Return linear interpolation from every other node to a rank's nodes, and the coarse lattice.

    Returns
    -------
    csr : tuple of array
        Row starts, columns and values of the rank's rows.
    coarse : array of bool
        The coarse lattice's nodes: the second, fourth, ... of the second, fourth, ... row; or of all rows, where they
        are fewer than three.
    of_coarse : slice
        The coarse nodes that are the rank's own: those that stand at its nodes.
    """
    steps = [2 if length > 2 else 1 for length in mask.shape]
    coarse = mask[steps[0] - 1 :: steps[0], steps[1] - 1 :: steps[1]]
    numbers = np.full([length + 2 for length in coarse.shape], -1)  # with a ring
    numbers[1:-1, 1:-1][coarse] = np.arange(np.count_nonzero(coarse))
    places = np.flatnonzero(mask)
    sides = []
    for at, step in zip(np.divmod(places[mine], mask.shape[1]), steps, strict=True):
        between = (at % 2 == 0) & (step == 2)
        before, behind = (at - 1) // 2 if step == 2 else at, at // step
        sides.append(((before, np.where(between, 0.5, 1.0)), (behind, np.where(between, 0.5, 0.0))))
    columns, weights = [], []
    for row, row_weight in sides[0]:
        for column, column_weight in sides[1]:
            columns.append(numbers[row + 1, column + 1])
            weights.append(row_weight * column_weight)
    found, values = np.column_stack(columns), np.column_stack(weights)
    kept = (found >= 0) & (values > 0.0)
    starts = np.concatenate([[0], np.cumsum(np.count_nonzero(kept, axis=1))])
    rows, along = np.nonzero(coarse)
    beneath = np.searchsorted(
        places, (steps[0] * rows + steps[0] - 1) * mask.shape[1] + steps[1] * along + steps[1] - 1
    )
    of_coarse = slice(*(int(end) for end in np.searchsorted(beneath, (mine.start, mine.stop))))
    return (starts, found[kept], values[kept]), coarse, of_coarse


class _Renewed:
    """A preconditioner for the free nodes, which is made anew where these are others.

    PETSc 3.18 keeps the sizes of GAMG's coarsest level, and refuses others. Where the nodes are those of the call
    before, as they are when a smaller residual is asked for, so is the preconditioner.

    Parameters
    ----------
    system : System
    levels : _Algebraic or _Geometric
    """

    def __init__(self, system: System, levels: _Algebraic | _Geometric) -> None:
        self._system, self._levels = system, levels
        self._snes: Any = None
        self._made: Any = None
        self._program: _Program | None = None
        self._free: Any = None

    def serve(self, program: _Program, snes: Any) -> None:
        """Precondition what a solver of a program asks for from now on."""
        if program is not self._program:
            self._free = None
        self._program, self._snes = program, snes

    def setUp(self, pc: Any) -> None:
        """Make it for the operators of now."""
        free = self._snes.getVIInactiveSet()
        numbers = np.array(free.getIndices())
        others = self._free is None or not np.array_equal(numbers, self._free)
        if self._system.total(float(others)) == 0.0:
            return
        if self._made is not None:
            self._made.destroy()
        assert self._program is not None
        self._made = self._levels.preconditioner(self._program, pc.getOperators()[1], free)
        self._free = numbers

    def apply(self, _pc: Any, vector: Any, result: Any) -> None:
        """Apply it."""
        self._made.apply(vector, result)


class _Log:
    """What is recorded of the steps, and the clock."""

    def __init__(self, system: System, told: Mapping[str, Any]) -> None:
        self._system, self._records = system, bool(told["history"])
        self._end = np.inf if told["seconds"] is None else time.monotonic() + told["seconds"]
        self._before: Any = None
        self.steps, self.left = 0, False
        self.history: dict[str, list[float]] = {"active": [], "changed": [], "residual": []} if self._records else {}

    def look(self, *_: Any) -> None:
        """Look at the clock; all ranks leave together."""
        if self._system.total(float(time.monotonic() > self._end)):
            self.left = True
            raise _Left

    def step(self, snes: Any, number: int, norm: float) -> None:
        """Take down how a step has ended."""
        self.steps = number
        if self._records:
            self._record(snes, number, norm)
        self.look()

    def _record(self, snes: Any, number: int, norm: float) -> None:
        program = self._system.program
        gap, residual = snes.getSolution().getArray(), snes.getFunction()[0].getArray()
        low = (gap <= program.lower.getArray()) & (residual > 0)
        high = (gap >= program.upper.getArray()) & (residual < 0)
        sides = low.astype(np.int8) - high.astype(np.int8)
        if number:
            self.history["active"].append(self._system.total(float(np.count_nonzero(sides))))
            self.history["changed"].append(self._system.total(float(np.count_nonzero(sides != self._before))))
            self.history["residual"].append(norm)
        self._before = sides


def main(folder: Path, caller: int) -> None:
    """Answer what is asked in a folder, until nobody can ask any more.

    The first question makes the system; its settings tell the options, and how many ranks there must be.
    """
    import petsc4py

    number = 0
    asked = _awaited(folder, number, caller)
    if asked is None:
        return
    options, ranks = asked["settings"]["options"], asked["settings"]["ranks"]
    petsc4py.init(["contactqp", *_as_arguments(options)])  # some are asked for at the start alone
    from petsc4py import PETSc

    found = PETSc.COMM_WORLD.getSize()
    (folder / f"{os.getpid()}.pid").touch()
    if found != ranks:
        raise RuntimeError(
            f"PETSc sees {found} ranks where {ranks} were started: this mpiexec belongs to another MPI than PETSc's"
        )
    system = System(asked["arrays"], options)
    system.comm.barrier()
    _answer(folder, number, system.rank, None, {})
    while True:
        number += 1
        asked = _awaited(folder, number, caller)
        if asked is None:
            return
        part, facts = getattr(system, asked["method"])(asked["arrays"], asked["settings"])
        if part is not None:
            _write_part(folder, number, system, part)
        # The caller removes the files when it is answered: by then all ranks have read the question and written.
        system.comm.barrier()
        _answer(folder, number, system.rank, part, facts)


def _as_arguments(options: Mapping[str, Any]) -> list[str]:
    return [word for name, value in options.items() for word in (f"-{name}", _text(value)) if word is not None]


def _text(value: Any) -> str | None:
    """Return an option's value as PETSc reads it."""
    return None if value is None else str(value).lower() if isinstance(value, bool) else str(value)


def _awaited(folder: Path, number: int, caller: int) -> dict[str, Any] | None:
    """Return the next question, its arrays left in their files, or None where nobody can ask any more."""
    file, since = folder / f"{number}.json", time.monotonic()
    while not file.exists():
        if not (folder.exists() and _lives(caller) and os.getppid() == _PARENT):
            shutil.rmtree(folder, ignore_errors=True)
            return None
        time.sleep(_OFTEN if time.monotonic() - since < _SOON else _SELDOM)
    asked: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    arrays = (folder / str(number)).glob("*.npy")
    return {**asked, "arrays": {path.stem: np.load(path, mmap_mode="r") for path in arrays}}


def _lives(process: int) -> bool:
    """Whether a process is there: mpiexec, which starts the ranks, outlives whoever started it, or ends before."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def _write_part(folder: Path, number: int, system: System, part: Any) -> None:
    """Write this rank's share of a vector."""
    path = folder / f"{number}.npy"
    if system.rank == 0:
        np.lib.format.open_memmap(path, mode="w+", dtype=np.float64, shape=(system.program.gap.getSize(),)).flush()
    system.comm.barrier()
    whole = np.lib.format.open_memmap(path, mode="r+")
    whole[system.mine] = part
    whole.flush()


def _answer(folder: Path, number: int, rank: int, part: Any, facts: Mapping[str, Any]) -> None:
    if rank == 0:
        whole = folder / f"{number}.part"
        whole.write_text(json.dumps({"facts": facts, "vector": part is not None}), encoding="utf-8")
        whole.replace(folder / f"{number}.done")


def _told(error: Exception) -> str:
    """Return an error's words, of PETSc's without the places in its source."""
    lines = [line for line in str(error).splitlines() if "() at " not in line]
    words = " ".join(line.partition("] ")[2] if line.startswith("[") else line for line in lines)
    return f"{type(error).__name__}: {words}"


if __name__ == "__main__":
    _folder = Path(sys.argv[1])
    try:
        main(_folder, int(sys.argv[2]))
    except Exception as error:
        _words = _folder / f"{os.getpid()}.words"
        _words.write_text(_told(error), encoding="utf-8")
        _words.replace(_words.with_suffix(".failed"))
        os._exit(1)  # the other ranks may wait for this one
