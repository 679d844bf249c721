"""Answers that may be moved along the kernel: their problem has more than one solution."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.proof.play import play

RING = 2 * np.eye(16) - np.roll(np.eye(16), 1, axis=0) - np.roll(np.eye(16), -1, axis=0)
WAVE = np.sin(2 * np.pi * np.arange(16) / 16)


def loose(**changes):
    given = {"lower": 0.0, "upper": 1.0, "kernel": "constant"}
    return cq.ContactQP(RING, np.zeros(16), **given | changes)


def test_without_forces_any_constant_between_the_bounds_is_a_solution():
    solution = cq.solve(loose(), on_failure="ignore")
    assert solution.play == pytest.approx(1.0)
    assert solution.status is cq.Status.UNPROVEN
    told = (
        "the solution is not unique: moved along the kernel by up to 1, the answer meets the same conditions, "
        "to rounding"
    )
    assert solution.cautions == (told,)
    assert told in " ".join(repr(solution).split())
    assert "Add a force or a bound that decides which of the solutions is meant." in repr(solution)
    with pytest.warns(cq.ContactWarning, match="Add a force or a bound that decides"):
        cq.solve(loose())


def test_a_comparison_says_so_and_accuses_nobody():
    comparison = cq.compare(loose(), ["active-set", "osqp", "clarabel", "psor"])
    assert comparison.false_claims == {}
    assert list(comparison.unproven_claims) == ["active-set", "osqp", "clarabel", "psor"]
    assert "Caution: the solution is not unique" in repr(comparison)


def test_a_wave_that_no_bound_holds_may_be_shifted():
    problem = loose(lower=-100.0, upper=100.0).with_forces(0.01 * WAVE)
    gap = -0.01 * np.linalg.pinv(RING) @ WAVE
    room = 100.0 - np.abs(gap).max()
    assert play(problem, gap, 1e-9) == pytest.approx(room)
    assert play(problem, gap + room, 1e-9) == pytest.approx(2 * room)


def test_a_force_that_rounding_nearly_hides_holds_the_answer():
    """q presses along the kernel by 2⁻⁴²: the solution (0, 1) is the only one, and certified by active sets."""
    row = [[1.0, -1.0], [-1.0, 1.0]]
    problem = cq.ContactQP(row, [1.0, -1.0 + 2.0**-42], lower=0.0, upper=5.0, kernel="constant")
    assert cq.solve(problem, "active-set").status == "certified"
    assert play(problem, np.array([0.54, 1.54]), 1e-9) == 0.0


@pytest.mark.parametrize("force", [1e-3, -1e-3])
def test_forces_that_press_leave_no_play(force):
    solution = cq.solve(loose().with_forces(np.full(16, force)))
    assert solution.play == 0.0
    assert play(solution.problem, solution.gap, 1e-9) == 0.0


def test_contact_below_and_above_holds_a_wave_without_a_sum():
    problem = loose(lower=-0.02, upper=0.02).with_forces(0.05 * WAVE)
    solution = cq.solve(problem)
    assert solution.status is cq.Status.CERTIFIED
    assert play(problem, solution.gap, 1e-9) == 0.0


def test_of_two_parts_the_one_that_nothing_presses_is_loose():
    row = np.array([[1.0, -1.0], [-1.0, 1.0]])
    parts = np.kron(np.eye(2), row)
    kernel = np.kron(np.eye(2), np.ones((2, 1)))
    problem = cq.ContactQP(parts, [1.0, 1.0, 0.0, 0.0], lower=0.0, upper=0.5, kernel=kernel)
    assert play(problem, np.array([0.0, 0.0, 0.1, 0.1]), 1e-9) == pytest.approx(0.4)
    assert play(problem.with_forces([1.0, 1.0, 0.0, 1e-6]), np.array([0.0, 0.0, 0.1, 0.1]), 1e-9) == 0.0


def test_without_a_kernel_there_is_none():
    assert cq.solve(cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])).play == 0.0
