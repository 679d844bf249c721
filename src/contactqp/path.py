"""Load paths: one model under a sequence of loads, tensions or lifts of its support, solved from one to the next."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ._checks import Vector, one_of, real_array, refuse_non_finite
from .backends import choose_backend, get_backend
from .certificate import Bracket
from .model import ContactModel
from .progress import Progress
from .rounding import UNIT_ROUNDOFF
from .solution import Solution
from .solve import solve
from .variation import VARIED

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from .touchdown import Touchdown

_CLOSING = {"load": 1, "tension": -1, "lift": 1}
"""Whether gaps shrink as the parameter grows, if the load nowhere pulls upwards."""


@dataclass(frozen=True, eq=False)
class LoadPath:
    """The solutions of one model along a parameter.

    Made by `trace`. Printing it shows a table; `to_frame` returns the table as data, `to_dataset` all fields.

    Attributes
    ----------
    model : Membrane, Cable or CableNet
        The model that is varied.
    parameter : str
        ``"load"`` (factor of the model's load), ``"tension"`` or ``"lift"`` (of the support, length).
    values : array, shape (k,)
        In the order of the path.
    solutions : tuple of Solution
        One for each value.
    cold_iterations : tuple of int, or None
        Iterations from a cold start, if they were asked for.
    """

    model: ContactModel
    parameter: str
    values: Vector
    solutions: tuple[Solution, ...]
    cold_iterations: tuple[int, ...] | None = None

    @property
    def contact_fraction(self) -> Vector:
        """Nodes in contact over nodes with a support, for each value, in the backend's own view."""
        supported = max(1, int(np.count_nonzero(self.model.supported)))
        return np.array([np.count_nonzero(solution.contact) / supported for solution in self.solutions])

    @property
    def total_reaction(self) -> list[Bracket]:
        """Brackets of the total reaction (force), for each value; nan where there is no certificate."""
        unknown = Bracket(float("nan"), float("nan"))
        return [unknown if solution.certificate is None else solution.total_reaction for solution in self.solutions]

    @property
    def max_deflection(self) -> Vector:
        """Largest deflection (length), for each value."""
        return np.array([float(solution.deflection.max()) for solution in self.solutions])

    @cached_property
    def findings(self) -> tuple[str, ...]:
        """Proven violations of the monotonicity that theory promises: gaps that grow, and nodes that lift off.

        Under a load that nowhere pulls upwards gaps only shrink and contact only grows as the load grows or the tension
        falls; under any load they do as the support is lifted. A violation is proven if the enclosures exclude the
        contrary, by more than the rounding of the stored data explains. Where nothing is promised, a finding says so.
        """
        return tuple(_violations(self))

    @property
    def monotone(self) -> bool:
        """Whether no violation of monotonicity is proven."""
        return not self.findings

    @property
    def promised(self) -> bool:
        """Whether theory promises monotonicity: the support is lifted, or the load nowhere pulls upwards."""
        return self.parameter == "lift" or bool((self.model.load >= 0).all())

    def touchdown(self, width: float | None = None) -> Touchdown:
        """Return for each node the loads between which it certainly comes into contact.

        Parameters
        ----------
        width : float, optional
            Wanted width of every bracket, > 0; further values between those of the path are solved for by bisection
            until it is reached. By default the path's own values are all that is used.

        Raises
        ------
        ValueError
            If monotonicity is violated, or the parameter is not the load.
        """
        from .touchdown import touchdown_of

        return touchdown_of(self, width)

    def to_frame(self) -> pd.DataFrame:
        """Return one row for each value, as a pandas.DataFrame indexed by the parameter.

        Columns: status, relative_bound, contact, contact_fraction, undecided, total_reaction_lower,
        total_reaction_upper (force), max_deflection (length), iterations, cold_iterations (if recorded), seconds.
        """
        import pandas as pd

        reactions = self.total_reaction
        columns: dict[str, Any] = {
            "status": [solution.status.value for solution in self.solutions],
            "relative_bound": [solution.relative_bound for solution in self.solutions],
            "contact": [int(np.count_nonzero(solution.contact)) for solution in self.solutions],
            "contact_fraction": self.contact_fraction,
            "undecided": [_undecided(solution) for solution in self.solutions],
            "total_reaction_lower": [bracket.lower for bracket in reactions],
            "total_reaction_upper": [bracket.upper for bracket in reactions],
            "max_deflection": self.max_deflection,
            "iterations": [solution.iterations for solution in self.solutions],
        }
        if self.cold_iterations is not None:
            columns["cold_iterations"] = list(self.cold_iterations)
        columns["seconds"] = [solution.seconds for solution in self.solutions]
        return pd.DataFrame(columns, index=pd.Index(self.values, name=self.parameter))

    def to_dataset(self) -> xr.Dataset:
        """Return all fields as an xarray.Dataset with the parameter as first dimension, and the table's columns.

        The field of active loads is called ``active_load``, because ``load`` is the dimension.
        """
        import xarray as xr

        fields = [solution.to_dataset().rename(load="active_load") for solution in self.solutions]
        place = xr.Variable((self.parameter,), self.values)
        data = xr.concat(fields, dim=place, combine_attrs="drop_conflicts")
        for name, column in self.to_frame().items():
            data[str(name)] = ((self.parameter,), column.to_numpy())
        data.attrs["parameter"] = self.parameter
        return data

    def plot(self) -> Figure:
        """Draw contact fraction, total reaction, largest deflection and iterations against the parameter."""
        from .plotting_path import plot_path

        return plot_path(self)

    def plot_touchdown(self, width: float | None = None) -> Figure:
        """Draw at which load each node settles: the contact maps of all loads in one picture.

        Parameters
        ----------
        width : float, optional
            See `touchdown`.
        """
        from .plotting_path import plot_touchdown

        return plot_touchdown(self.touchdown(width))

    @property
    def verdict(self) -> str:
        """The first finding and the number of others, or that there is none."""
        if not self.findings:
            return "no violation of monotonicity"
        others = len(self.findings) - 1
        return self.findings[0] + (f"; and {others} more finding{'s' if others > 1 else ''}" if others else "")

    def __repr__(self) -> str:
        table = self.to_frame()[["status", "relative_bound", "contact", "undecided", "max_deflection", "iterations"]]
        text = table.to_string(float_format=lambda number: f"{number:.4g}")
        return f"LoadPath({self.model!r}, {len(self.solutions)} {self.parameter}s)\n{text}\n{self.verdict}"


def trace(
    model: ContactModel,
    *,
    loads: Iterable[float] | None = None,
    tensions: Iterable[float] | None = None,
    lifts: Iterable[float] | None = None,
    backend: str = "auto",
    tol: float | str = 1e-6,
    cold: bool = False,
    checkpoint: str | Path | None = None,
    on_failure: Literal["warn", "raise", "ignore"] = "warn",
    **options: Any,
) -> LoadPath:
    """Solve a model along a sequence of loads, tensions or lifts, each from the answer before.

    Parameters
    ----------
    model : Membrane, Cable or CableNet
        What is varied; it is never modified.
    loads : sequence of float, optional
        Factors of the model's load: proportional loading. Give exactly one of loads, tensions and lifts.
    tensions : sequence of float, optional
        Tensions, > 0; not for a net of cables.
    lifts : sequence of float, optional
        Heights (length) by which the support is lifted.
    backend, tol, on_failure, **options
        As for `solve`.
    cold : bool
        Whether to solve from a cold start as well, to count the iterations that warm starts save.
    checkpoint : path, optional
        A NetCDF file that keeps what is done after every value, so that an interrupted path is resumed from it by the
        same call. It must belong to the same model, parameter and backend.

    Returns
    -------
    LoadPath

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind or range, or the checkpoint belongs to another path.
    NotCertifiedError
        If an answer is not certified and ``on_failure="raise"``.

    Examples
    --------
    >>> import contactqp as cq
    >>> path = cq.trace(cq.gallery.paper_hexagon(load=1.0), loads=[0.01, 0.02, 0.03])
    >>> path.to_frame()["contact"].tolist(), path.monotone
    ([105, 225, 303], True)
    """
    if not isinstance(model, ContactModel):
        raise TypeError(f"model must be a Membrane, a Cable or a CableNet, got {type(model).__name__}")
    parameter, values = _chosen({"load": loads, "tension": tensions, "lift": lifts})
    if backend == "auto":
        backend = choose_backend(model.problem)[0]
    limits = {"max_iter", "time_limit"}
    get_backend(backend).check_options({name: value for name, value in options.items() if name not in limits})
    one_of(on_failure, ("warn", "raise", "ignore"), "on_failure")
    file = None
    if checkpoint is not None:
        from .checkpoint import Checkpoint

        file = Checkpoint(Path(checkpoint), model, parameter, backend)
    restored = [] if file is None else file.restored(values, tol)
    settings = {"tol": tol, "on_failure": on_failure, **options}
    solutions: list[Solution] = []
    cold_iterations: list[int] = []
    with Progress(f"{parameter}s · {model.size} nodes") as progress:
        for k, value in enumerate(values):
            progress.update(f"{parameter} {value:g}, {k + 1} of {values.size}")
            varied = VARIED[parameter](model, float(value))
            kept, counted = restored[k] if k < len(restored) else (None, -1)
            start = _start(solutions[-1] if solutions else None)
            if kept is not None and kept.status.ok:
                solution = kept
            else:
                own = None if kept is None else _start(kept)
                solution = solve(varied, backend, warm_start=start if own is None else own, **settings)
            if cold and counted < 0:
                counted = solution.iterations if start is None else solve(varied, backend, **settings).iterations
            solutions.append(solution)
            cold_iterations.append(counted)
            if file is not None and (solution is not kept or counted >= 0):
                file.keep(values[: k + 1], solutions, cold_iterations)
    return LoadPath(model, parameter, values, tuple(solutions), tuple(cold_iterations) if cold else None)


def _start(solution: Solution | None) -> Vector | None:
    """Return the gap to go on from, None if there is no finite one."""
    return None if solution is None or solution.residuals is None else solution.gap


def _chosen(given: dict[str, Iterable[float] | None]) -> tuple[str, Vector]:
    named = {name: values for name, values in given.items() if values is not None}
    if len(named) != 1:
        got = ", ".join(f"{name}s" for name in named) or "none of them"
        raise ValueError(f"give exactly one of loads, tensions and lifts, got {got}")
    ((parameter, chosen),) = named.items()
    values = real_array(list(chosen) if not isinstance(chosen, np.ndarray) else chosen, f"{parameter}s")
    if values.ndim != 1 or not values.size:
        raise ValueError(f"{parameter}s must be a sequence of numbers, got shape {values.shape}")
    refuse_non_finite(values, f"{parameter}s")
    if parameter == "tension" and not (values > 0).all():
        raise ValueError(f"tensions must be > 0, got {values.min():g}")
    if np.unique(values).size != values.size:
        raise ValueError(f"{parameter}s must not repeat a value")
    return parameter, values


def _undecided(solution: Solution) -> int:
    certificate = solution.certificate
    return solution.problem.size if certificate is None else int(np.count_nonzero(certificate.undecided))


def _violations(path: LoadPath) -> Iterable[str]:
    order = np.argsort(path.values * _CLOSING[path.parameter])
    caution = "" if path.promised else " (the load also pulls upwards, so nothing else was promised)"
    for earlier, later in pairwise(order):
        first, second = path.solutions[earlier], path.solutions[later]
        if first.certificate is None or second.certificate is None:
            continue
        between = f"between {path.parameter} {path.values[earlier]:g} and {path.values[later]:g}"
        rounding = _rounding_of_data(path, earlier) + _rounding_of_data(path, later)
        grown = np.where(path.model.supported, second.certificate.lower - first.certificate.upper - rounding, -np.inf)
        worst = int(np.argmax(grown))
        if grown[worst] > 0:
            node = path.model.describe(worst)
            yield f"the gap grows {between}, by at least {grown[worst]:.2g} at {node}{caution}"
        lifted = np.flatnonzero(
            first.certificate.contact & (second.certificate.lower > rounding) & path.model.supported
        )
        if lifted.size:
            node = path.model.describe(int(lifted[0]))
            yield f"{lifted.size} node(s) lift off {between}, the first {node}{caution}"


def _rounding_of_data(path: LoadPath, k: int) -> Vector:
    """Return how far rounding errors of f and q, in a varied model, can move its gaps (length), shape (n,).

    Under a load that grows, every q grows even as it is rounded.
    """
    problem, model = path.solutions[k].problem, path.solutions[k].model
    if path.parameter == "load" or model is None or problem.barrier is None:
        return np.zeros(path.model.size)
    heights = np.abs(model.reference).max() + np.abs(path.model.support[path.model.supported]).max(initial=0.0)
    heights += abs(path.values[k]) + abs(model._datum) + model._frame_relief()
    force = np.abs(model.nodal_load) + 4 * problem.stiffness.diagonal() * heights
    return np.asarray(4 * UNIT_ROUNDOFF * (problem.barrier.v * float((force / problem.barrier.s).max()) + heights))
