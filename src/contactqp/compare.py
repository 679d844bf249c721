"""compare(): one problem, several backends, and whether they agree."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from ._checks import integer_at_least, open_interval, positive_number
from .backends import choose_backend, get_backend, suitable_backends
from .errors import MissingBackendError, UnsuitableProblemError
from .judge import Status
from .model import TensionedNet
from .problem import ContactQP
from .solution import Solution
from .solve import solve

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

UNPROVEN_AGREEMENT = 100.0
"""Without enclosures two answers agree if they differ by at most this times tol times the gap scale."""


@dataclass(frozen=True)
class Row:
    """What one backend achieved; a backend that could not run has ``message`` and no solution.

    Attributes
    ----------
    backend : str
    status : str
        A `Status`, ``"missing"`` (library not installed), ``"unsuitable"`` (the method does not apply) or ``"error"``.
    message : str
        The backend's own words, or the error's.
    iterations : int or None
    setup_seconds, solve_seconds : float or None
    min_gap, min_reaction, complementarity, natural_residual, objective : float or None
        See `Residuals`.
    relative_bound : float or None
        Certified bound over the gap scale.
    contact : int or None
        Nodes in contact in the backend's own view.
    certain_contact, certain_clear, undecided : int or None
        Nodes that the certificate decides, and those that it does not.
    """

    backend: str
    status: str
    message: str
    iterations: int | None = None
    setup_seconds: float | None = None
    solve_seconds: float | None = None
    min_gap: float | None = None
    min_reaction: float | None = None
    complementarity: float | None = None
    natural_residual: float | None = None
    objective: float | None = None
    relative_bound: float | None = None
    contact: int | None = None
    certain_contact: int | None = None
    certain_clear: int | None = None
    undecided: int | None = None


@dataclass(frozen=True)
class Pair:
    """How two backends' answers differ.

    Attributes
    ----------
    first, second : str
        The backends.
    gap_difference : float
        max |Δω| (length).
    contact_jaccard : float
        1 - |intersection| / |union| of the two contact sets: 0 if they are equal.
    differing_nodes : array of int
        Nodes that one has in contact and the other does not.
    consistent : bool
        Whether one solution can satisfy both enclosures (without enclosures: whether the gaps differ by at most
        100 tol times the gap scale).
    """

    first: str
    second: str
    gap_difference: float
    contact_jaccard: float
    differing_nodes: np.ndarray[Any, np.dtype[np.int64]]
    consistent: bool


class Comparison:
    """The answers of several backends to one problem, side by side.

    Made by `compare`. Printing it shows a table; `to_frame` returns the table as data.

    Attributes
    ----------
    problem : ContactQP
    tol : float
    rows : list of Row
        One for each backend, in the order asked for.
    solutions : dict of str to Solution
        By backend, of those that returned one.
    """

    def __init__(
        self, problem: ContactQP, subject: str, tol: float, rows: list[Row], solutions: dict[str, Solution]
    ) -> None:
        self.problem = problem
        self.subject = subject
        self.tol = tol
        self.rows = rows
        self.solutions = solutions

    @cached_property
    def pairs(self) -> list[Pair]:
        """Every pair of backends that returned a finite answer."""
        usable = {name: s for name, s in self.solutions.items() if s.residuals is not None}
        return [self._pair(first, second, usable[first], usable[second]) for first, second in combinations(usable, 2)]

    @property
    def agree(self) -> bool:
        """Whether every backend was certified and every pair of enclosures intersects."""
        return (
            bool(self.rows)
            and all(row.status in (Status.CERTIFIED, Status.SOLVED) for row in self.rows)
            and all(pair.consistent for pair in self.pairs)
        )

    @cached_property
    def culprits(self) -> dict[str, str]:
        """Why there is no agreement: backend to reason, empty if all agree.

        A backend is named if it returned no certified answer, with its worst optimality condition; or, where all look
        good and two still exclude each other, if its answer is consistent with fewer of the others than theirs are.
        """
        found = {row.backend: self._complaint(row) for row in self.rows if row.status not in ("certified", "solved")}
        if found or all(pair.consistent for pair in self.pairs):
            return found
        conflicts = dict.fromkeys(self.solutions, 0)
        for pair in self.pairs:
            if not pair.consistent:
                conflicts[pair.first] += 1
                conflicts[pair.second] += 1
        most = max(conflicts.values())
        return {
            name: f"excludes the answers of {count} of {len(self.solutions) - 1} other backends"
            for name, count in conflicts.items()
            if count == most
        }

    def to_frame(self) -> pd.DataFrame:
        """Return the rows as a pandas.DataFrame, indexed by backend."""
        import pandas as pd

        return pd.DataFrame([asdict(row) for row in self.rows]).set_index("backend")

    def pairs_frame(self) -> pd.DataFrame:
        """Return the pairs as a pandas.DataFrame, with the number of differing nodes."""
        import pandas as pd

        records = [asdict(pair) | {"differing_nodes": pair.differing_nodes.size} for pair in self.pairs]
        return pd.DataFrame(records, columns=list(Pair.__dataclass_fields__))

    def to_json(self, indent: int | None = 2) -> str:
        """Return rows, pairs, verdict and culprits as JSON; infinite and undefined numbers become null."""
        pairs = [asdict(pair) | {"differing_nodes": pair.differing_nodes.tolist()} for pair in self.pairs]
        record = {
            "problem": self.subject,
            "tol": self.tol,
            "gap_scale": self.problem.gap_scale,
            "agree": self.agree,
            "culprits": self.culprits,
            "backends": [asdict(row) for row in self.rows],
            "pairs": pairs,
        }
        return json.dumps(_plain(record), indent=indent, allow_nan=False)

    def plot(self) -> Figure:
        """Draw the best answer's contact map, each backend's certified error, and where contact sets differ."""
        from .plotting import plot_comparison

        return plot_comparison(self)

    @property
    def best(self) -> Solution | None:
        """The answer with the smallest certified bound, or None if no backend returned one."""
        usable = [s for s in self.solutions.values() if s.residuals is not None]
        return min(usable, key=lambda s: s.relative_bound) if usable else None

    def verdict(self) -> str:
        """Return one sentence: agreement, or who spoils it and why."""
        if self.agree:
            largest = max((pair.gap_difference for pair in self.pairs), default=0.0)
            differing = max((pair.differing_nodes.size for pair in self.pairs), default=0)
            proof = "certified" if self.problem.is_m_matrix else "within tol by their residuals"
            same = "the same contact set" if not differing else f"contact sets that differ in up to {differing} nodes"
            return f"All {len(self.rows)} backends agree: {proof}, max gap difference {largest:.2g}, {same}."
        reasons = "; ".join(f"{name} {why}" for name, why in self.culprits.items())
        return f"No agreement: {reasons or 'no backend was asked'}."

    def __repr__(self) -> str:
        headings, body = table_cells(self)
        table = [headings, *body]
        widths = [max(len(line[k]) for line in table) for k in range(len(headings))]
        lines = [
            "  ".join(
                cell.ljust(width) if k < 2 else cell.rjust(width)
                for k, (cell, width) in enumerate(zip(line, widths, strict=True))
            )
            for line in table
        ]
        head = f"{self.subject}, tol {self.tol:g} of the gap scale {self.problem.gap_scale:.3g}"
        return "\n".join([head, "", *(line.rstrip() for line in lines), "", self.verdict()])

    def _repr_html_(self) -> str:
        from html import escape

        headings, rows = table_cells(self)
        head = "".join(f"<th>{escape(heading)}</th>" for heading in headings)
        body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
        return (
            f"<p>{escape(self.subject)}, tol {self.tol:g}</p>"
            f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table><p>{escape(self.verdict())}</p>"
        )

    def _pair(self, first_name: str, second_name: str, first: Solution, second: Solution) -> Pair:
        union = int(np.count_nonzero(first.contact | second.contact))
        differing = np.flatnonzero(first.contact != second.contact)
        difference = float(np.abs(first.gap - second.gap).max())
        if first.certificate is not None and second.certificate is not None:
            consistent = first.certificate.intersects(second.certificate)
        else:
            consistent = difference <= UNPROVEN_AGREEMENT * self.tol * self.problem.gap_scale
        return Pair(
            first=first_name,
            second=second_name,
            gap_difference=difference,
            contact_jaccard=differing.size / union if union else 0.0,
            differing_nodes=differing,
            consistent=consistent,
        )

    def _complaint(self, row: Row) -> str:
        if row.relative_bound is None or row.natural_residual is None:
            return f"({row.status}: {row.message})"
        scale = self.problem.gap_scale
        stiffness = float(self.problem.stiffness.diagonal().max())
        violations = {
            f"min gap {row.min_gap:.2g}": -(row.min_gap or 0.0) / scale,
            f"min reaction {row.min_reaction:.2g}": -(row.min_reaction or 0.0) / (stiffness * scale),
            f"natural residual {row.natural_residual:.2g}": row.natural_residual / scale,
        }
        worst = max(violations, key=lambda label: violations[label])
        return f"({row.status}: bound {row.relative_bound:.2g} > tol {self.tol:g}, {worst})"


def compare(
    problem: ContactQP | TensionedNet,
    backends: Sequence[str] | None = None,
    *,
    tol: float = 1e-6,
    max_iter: int | None = None,
    time_limit: float | None = None,
    options: Mapping[str, Mapping[str, Any]] | None = None,
) -> Comparison:
    """Solve one problem with several backends and cross-check the answers.

    A backend that is missing, unsuitable, fails or times out is a row of the result, never an exception.

    Parameters
    ----------
    problem : Membrane, Cable or ContactQP
        What to solve.
    backends : sequence of str, optional
        Names, see `backend_names`; by default the package's own whose methods suit the problem.
    tol : float
        As for `solve`, for every backend.
    max_iter : int, optional
        Iterations of each backend, in its own unit.
    time_limit : float, optional
        Seconds for each backend.
    options : mapping of str to mapping, optional
        Options of a backend, by its name.

    Returns
    -------
    Comparison

    Raises
    ------
    UnknownBackendError
        If there is no backend of a given name.
    TypeError, ValueError
        If an argument has the wrong kind or range, or a backend is named twice.

    Examples
    --------
    >>> import contactqp as cq
    >>> comparison = cq.compare(cq.gallery.paper_hexagon(), backends=["clarabel", "mangasarian"])
    >>> comparison.agree
    True
    >>> comparison.to_frame()["contact"].tolist()
    [303, 303]
    """
    if isinstance(backends, str):
        raise TypeError(f"backends must be a sequence of names, got the string {backends!r}; write [{backends!r}]")
    if not isinstance(problem, (ContactQP, TensionedNet)):
        raise TypeError(f"problem must be a Membrane, a Cable or a ContactQP, got {type(problem).__name__}")
    algebra = problem.problem if isinstance(problem, TensionedNet) else problem
    names = suitable_backends(algebra) if backends is None else list(backends)
    if len(set(names)) != len(names):
        raise ValueError(f"backends must not repeat, got {names}")
    options = dict(options or {})
    stray = sorted(set(options) - set(names))
    if stray:
        raise ValueError(f"options name {', '.join(map(repr, stray))}, which is not among the backends {names}")
    tol = open_interval(tol, 0.0, 1.0, "tol")
    if max_iter is not None:
        max_iter = integer_at_least(max_iter, 1, "max_iter")
    if time_limit is not None:
        time_limit = positive_number(time_limit, "time_limit")
    for name in names:
        chosen = choose_backend(algebra)[0] if name == "auto" else name
        get_backend(chosen).check_options(options.get(name, {}))
    rows: list[Row] = []
    solutions: dict[str, Solution] = {}
    for name in names:
        limits = {"tol": tol, "max_iter": max_iter, "time_limit": time_limit}
        outcome = _attempt(problem, name, limits, options.get(name, {}))
        if isinstance(outcome, Solution):
            solutions[name] = outcome
            rows.append(_row(outcome, name))
        else:
            rows.append(outcome)
    return Comparison(algebra, repr(problem), tol, rows, solutions)


def _attempt(
    problem: ContactQP | TensionedNet, name: str, limits: Mapping[str, Any], options: Mapping[str, Any]
) -> Solution | Row:
    try:
        return solve(problem, name, on_failure="ignore", **limits, **options)
    except MissingBackendError as error:
        return Row(name, "missing", str(error))
    except UnsuitableProblemError as error:
        return Row(name, "unsuitable", str(error))
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:  # whatever a library throws, a panic of compiled code too, is a finding about it
        return Row(name, "error", f"{type(error).__name__}: {error}")


def _row(solution: Solution, name: str) -> Row:
    facts: dict[str, Any] = {} if solution.residuals is None else solution.residuals.to_dict()
    if solution.residuals is not None:
        facts |= {
            "relative_bound": solution.relative_bound,
            "contact": int(np.count_nonzero(solution.contact)),
        }
    if solution.certificate is not None:
        facts |= {
            "certain_contact": int(np.count_nonzero(solution.certificate.contact)),
            "certain_clear": int(np.count_nonzero(solution.certificate.clear)),
            "undecided": int(np.count_nonzero(solution.certificate.undecided)),
        }
    return Row(
        backend=name,
        status=solution.status.value,
        message=solution.termination,
        iterations=solution.iterations,
        setup_seconds=solution.setup_seconds,
        solve_seconds=solution.solve_seconds,
        **facts,
    )


def table_cells(comparison: Comparison) -> tuple[list[str], list[list[str]]]:
    """Return the headings of a comparison's table and its rows, as text."""
    return list(_COLUMNS), [[cell(row) for cell in _COLUMNS.values()] for row in comparison.rows]


def _plain(value: Any) -> Any:
    """Return ``value`` with every float that JSON lacks replaced by None."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _number(value: float | None, digits: int = 2) -> str:
    return "-" if value is None else f"{value:.{digits}g}"


def _count(value: int | None) -> str:
    return "-" if value is None else str(value)


def _seconds(row: Row) -> str:
    if row.setup_seconds is None or row.solve_seconds is None:
        return "-"
    return f"{row.setup_seconds + row.solve_seconds:#.3g}"


_COLUMNS: dict[str, Callable[[Row], str]] = {
    "backend": lambda row: row.backend,
    "status": lambda row: row.status.replace("_", " "),
    "iterations": lambda row: _count(row.iterations),
    "seconds": _seconds,
    "bound/scale": lambda row: _number(row.relative_bound),
    "min gap": lambda row: _number(row.min_gap),
    "min R": lambda row: _number(row.min_reaction),
    "gap·R": lambda row: _number(row.complementarity),
    "contact": lambda row: _count(row.contact),
    "undecided": lambda row: _count(row.undecided),
    "objective": lambda row: _number(row.objective, 10),
}
