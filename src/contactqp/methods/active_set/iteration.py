"""What the iterations that exchange contact nodes have in common."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from ...foundation.checks import Vector
from .primal_dual import Step


class ActiveSets(Protocol):
    """An iteration that holds contact nodes at their bounds, solves for the others, and exchanges nodes."""

    def restart(self, q: Vector, lower: Vector, upper: Vector) -> None:
        """Go back to ω = 0 with other forces and other values of the bounds; ``upper`` is empty where there is none."""
        ...

    def start(self, report: Callable[[str], None] = ...) -> None:
        """Start from a cheap guess, where there is one."""
        ...

    def start_from(self, gap: Vector) -> None:
        """Start from a gap, shape (n,)."""
        ...

    def step(self) -> Step:
        """Exchange nodes, and solve for the others."""
        ...

    def feasible(self) -> Vector:
        """Return ω between its bounds, which it may leave on its way."""
        ...
