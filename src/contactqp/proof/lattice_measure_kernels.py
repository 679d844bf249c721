"""Compiled passes of judge and certificate over a lattice whose arms are equal in each direction.

Nodes may be held by springs to the ground as well, ``ground[i - 1, j - 1]``; without any, ``ground`` is a number.

They say in one pass over memory what `vector_measures` says in many, with the same bounds of rounding errors, so
they are compiled without any license to rearrange sums. ``rows`` and ``columns`` make up the barrier,
v[i, j] = rows[i] + columns[j], and ``s`` <= Gv.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import njit, types
from numba.extending import overload

from ..foundation.rounding import DIFFERENCES, UNDERFLOW, UNIT_ROUNDOFF, gamma
from ..geometry.arm_kernels import softened, with_spring
from ..geometry.numbering_kernels import GRID, READ_ONLY_VECTOR, RUNS
from ..geometry.runs import BOUNDED, FIRST, KIND, LAST, NODE, ROW, SUPPORTED

_ERROR, _ERROR_WITH_SPRINGS = gamma(DIFFERENCES), gamma(DIFFERENCES + 2)
"""Relative to the sum of the moduli; what a spring adds is rounded once more in the sum, and once more in its bound."""
_SLACK = 4 * UNIT_ROUNDOFF
_DOUBLE = 2 * UNIT_ROUNDOFF
_UNDERFLOW = UNDERFLOW

_BARRIER = "float64[::1], float64[::1], float64"
_BOUNDS = f"{READ_ONLY_VECTOR}, {READ_ONLY_VECTOR}"


def _error_of(ground: Any) -> float:
    """Return the rounding error of a reaction relative to the sum of its parts' moduli, bounded."""
    return _ERROR if np.ndim(ground) == 0 else _ERROR_WITH_SPRINGS


@overload(_error_of, inline="always")
def _compiled_error_of(ground):  # type: ignore[no-untyped-def]
    error = _ERROR if isinstance(ground, types.Float) else _ERROR_WITH_SPRINGS
    return lambda ground: error


@njit(inline="always")
def _reaction(omega, i, j, across, along, ground, force):  # type: ignore[no-untyped-def]
    """Return R = Gω + q at a node, formed from differences, and a bound of its rounding error."""
    own = omega[i, j]
    west, east = own - omega[i, j - 1], own - omega[i, j + 1]
    south, north = own - omega[i - 1, j], own - omega[i + 1, j]
    pull = across * (west + east) + along * (south + north)
    size = across * (abs(west) + abs(east)) + along * (abs(south) + abs(north))
    reaction = with_spring(pull, ground, i - 1, j - 1, own) + force
    magnitude = with_spring(size, ground, i - 1, j - 1, abs(own)) + abs(force)
    return reaction, _error_of(ground) * magnitude + _UNDERFLOW


def _measure(  # type: ignore[no-untyped-def]
    omega, q, reference, step, floor, ceiling, across, along, ground, runs, row_start, rows, columns, s, lo, hi
):
    """Measure ω on the rows [lo, hi).

    Returns the multiples τ⁺ and τ⁻ of the barrier (see `enclosure`), the least distance from a bound, the least R (with
    an upper bound alone, -R), the sums of ωR (with bounds other than zero, of R times the distance from the bound that
    it belongs to) and of ω(R + q)/2, the largest modulus of the natural residual, and the largest |reference - ω|. The
    first two are infinite if a number is too large for its error to be bounded. ``reference`` is indexed by ``step``
    times the node; ``floor`` and ``ceiling`` are the bounds of nodes that are `BOUNDED`.
    """
    raise_by, lower_by, least_gap, least_reaction = 0.0, 0.0, np.inf, np.inf
    work, energy, natural, size = 0.0, 0.0, 0.0, 0.0
    bounded = True
    # A product with a reciprocal is off by a few roundings, which the caller's factor covers; the reciprocal of a
    # subnormal number overflows, and then nothing is proven.
    per_s, per_diagonal = 1.0 / s, 0.5 / (across + along)
    for run in range(row_start[lo], row_start[hi]):
        i, first, last, node, kind = runs[run, ROW], runs[run, FIRST], runs[run, LAST], runs[run, NODE], runs[run, KIND]
        run_work = run_energy = 0.0
        for k in range(last - first):
            j = first + k
            gap, force = omega[i, j], q[node + k]
            reaction, error = _reaction(omega, i, j, across, along, ground, force)
            bounded = bounded and error < np.inf
            high, low = (error + reaction) * per_s, (error - reaction) * per_s
            correction = softened(reaction * per_diagonal, ground, i - 1, j - 1, per_diagonal)
            distance = gap
            if kind == SUPPORTED:
                clearance = gap / (rows[i] + columns[j])
                raise_by = max(raise_by, -clearance)
                high = min(high, clearance)
                least_gap = min(least_gap, gap)
                correction = min(correction, gap)
                least_reaction = min(least_reaction, reaction)
            elif kind == BOUNDED:
                v, below, above = rows[i] + columns[j], floor[node + k], ceiling[node + k]
                over_floor, under_ceiling = gap - below, above - gap
                # A rounded difference is off by half a unit in its last place, which twice the unit roundoff exceeds.
                low = min(low, (under_ceiling + _DOUBLE * abs(under_ceiling)) / v)
                low = max(low, (_DOUBLE * abs(over_floor) - over_floor) / v if below > -np.inf else -np.inf)
                high = min(high, (over_floor + _DOUBLE * abs(over_floor)) / v)
                high = max(high, (_DOUBLE * abs(under_ceiling) - under_ceiling) / v if above < np.inf else -np.inf)
                least_gap = min(least_gap, min(over_floor, under_ceiling))
                correction = max(min(correction, over_floor), -under_ceiling)
                if above == np.inf:
                    least_reaction = min(least_reaction, reaction)
                elif below == -np.inf:
                    least_reaction = min(least_reaction, -reaction)
                if reaction < 0.0 and above < np.inf:
                    distance = -under_ceiling
                elif below > -np.inf:
                    distance = over_floor
            else:
                least_reaction = min(least_reaction, reaction)
            raise_by, lower_by = max(raise_by, low), max(lower_by, high)
            natural = max(natural, abs(correction))
            size = max(size, abs(reference[step * (node + k)] - gap))
            run_work += distance * reaction
            run_energy += 0.5 * gap * (reaction + force)
        work += run_work
        energy += run_energy
    if not bounded:
        raise_by = lower_by = np.inf
    return raise_by, lower_by, least_gap, least_reaction, work, energy, natural, size


@njit(inline="always")
def _reaction_at(omega, i, j, own, across, along, ground, force, shift):  # type: ignore[no-untyped-def]
    """Return R at a node that is at a bound, with a shift that the others' bounds make, and a bound of its error.

    The neighbours are as far away as they can be: their arms pull by a force ``shift`` more than those of ω do.
    """
    west, east = own - omega[i, j - 1], own - omega[i, j + 1]
    south, north = own - omega[i - 1, j], own - omega[i + 1, j]
    pull = across * (west + east) + along * (south + north)
    size = across * (abs(west) + abs(east)) + along * (abs(south) + abs(north))
    reaction = (with_spring(pull, ground, i - 1, j - 1, own) + shift) + force
    magnitude = with_spring(size, ground, i - 1, j - 1, abs(own))
    return reaction, _error_of(ground) * (magnitude + abs(shift) + abs(force)) + _UNDERFLOW


@njit(inline="always")
def _upper(gap, rise):  # type: ignore[no-untyped-def]
    return (gap + rise) + (_SLACK * (abs(gap) + rise) + _UNDERFLOW)


def _enclose(  # type: ignore[no-untyped-def]
    omega,
    q,
    floor,
    ceiling,
    across,
    along,
    ground,
    runs,
    row_start,
    rows,
    columns,
    s,
    raise_by,
    lower_by,
    lower,
    upper,
    contact,
    contact_above,
    clear,
    lo,
    hi,
):
    """Write the enclosure on the rows [lo, hi); return the largest distance of ω from it, and whether all is finite."""
    bound, finite = 0.0, True
    for run in range(row_start[lo], row_start[hi]):
        i, first, last, node, kind = runs[run, ROW], runs[run, FIRST], runs[run, LAST], runs[run, NODE], runs[run, KIND]
        for k in range(last - first):
            j = first + k
            gap, v = omega[i, j], rows[i] + columns[j]
            high = _upper(gap, raise_by * v)
            fall = lower_by * v
            low = (gap - fall) - (_SLACK * (abs(gap) + fall) + _UNDERFLOW)
            west, east, south, north = omega[i, j - 1], omega[i, j + 1], omega[i - 1, j], omega[i + 1, j]
            # At frame points, which have gap 0 and no barrier, v need not be 0, but may count as if it were theirs.
            sideways = max(0.0, rows[i] + columns[j - 1]) + max(0.0, rows[i] + columns[j + 1])
            endways = max(0.0, rows[i - 1] + columns[j]) + max(0.0, rows[i + 1] + columns[j])
            lift = raise_by * (across * sideways + along * endways)
            pull = (across * (west + east) + along * (south + north)) + lift
            force = (across * (abs(west) + abs(east)) + along * (abs(south) + abs(north))) + lift
            drive = q[node + k]
            held_shut = drive - pull  # where this overflows, it is not above its error, and proves nothing
            error = _error_of(ground) * (force + abs(drive)) + _UNDERFLOW
            touching = False
            if kind == SUPPORTED:
                low = max(low, 0.0)
                touching = held_shut > 2 * error
                clear[node + k] = low > 0.0
                contact[node + k] = touching
                lower[node + k], upper[node + k] = (0.0, 0.0) if touching else (low, high)
            elif kind == BOUNDED:
                below, above = floor[node + k], ceiling[node + k]
                low, high = max(low, below), min(high, above)
                drop = lower_by * (across * sideways + along * endways)
                at_floor, error = _reaction_at(omega, i, j, below, across, along, ground, drive, -lift)
                touching = below > -np.inf and at_floor > 2 * error
                at_ceiling, error = _reaction_at(omega, i, j, above, across, along, ground, drive, drop)
                touching_above = above < np.inf and -at_ceiling > 2 * error
                clear[node + k] = (low > below or below == -np.inf) and (high < above or above == np.inf)
                contact[node + k] = touching or touching_above
                if contact_above.size:
                    contact_above[node + k] = touching_above
                if touching:
                    lower[node + k] = upper[node + k] = below
                elif touching_above:
                    lower[node + k] = upper[node + k] = above
                else:
                    lower[node + k], upper[node + k] = low, high
            else:
                clear[node + k], contact[node + k] = True, False
                lower[node + k], upper[node + k] = low, high
            bound = max(bound, max(high - gap, gap - low))
            finite = finite and np.isfinite(high) and np.isfinite(low)
    return bound, finite


class Passes(NamedTuple):
    """The passes, compiled."""

    measure: Any
    enclose: Any


@cache
def passes(springs: bool) -> Passes:
    """Compile the passes without springs or with some, or load them."""
    stiffnesses = f"float64, float64, {GRID if springs else 'float64'}"
    place = f"{stiffnesses}, {RUNS}, int64[::1]"
    measured = f"{GRID}, {READ_ONLY_VECTOR}, {READ_ONLY_VECTOR}, int64, {_BOUNDS}, {place}, {_BARRIER}, int64, int64"
    enclosed = (
        f"{GRID}, {READ_ONLY_VECTOR}, {_BOUNDS}, {place}, {_BARRIER}, float64, float64, float64[::1], float64[::1], "
        "boolean[::1], boolean[::1], boolean[::1], int64, int64"
    )
    return Passes(
        measure=_compiled(_measure, f"UniTuple(float64, 8)({measured})"),
        enclose=_compiled(_enclose, f"Tuple((float64, boolean))({enclosed})"),
    )


def _compiled(function: Any, signature: str) -> Any:
    return njit(signature, cache=True, nogil=True, error_model="numpy")(function)
