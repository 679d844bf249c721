"""The assertions for other programs' tests; those about single answers and agreement stand in test_compare."""

from dataclasses import replace

import numpy as np
import pytest
from strategies import BACKENDS, altered

import contactqp as cq
from contactqp.backends.base import Answer, Backend, Stop
from contactqp.proof.judge import judge
from contactqp.testing import assert_backends_agree, assert_complementary, assert_encloses, assert_same_contact

CABLE, DEFLECTION = cq.gallery.cable_on_floor(nodes=9, contact_starts_after=2)
EXACT = CABLE.support - DEFLECTION
BIACTIVE = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 0.5])  # gap (0.5, 0), reaction (0, 0)
ALL_TIED = cq.ContactQP(0.1 * np.eye(3) + 0.9, [-1.0, 0.0, 0.0])
"""No H-matrix: its positive off-diagonal entries outweigh the diagonal."""


@pytest.fixture(scope="module")
def solution():
    return cq.solve(CABLE, "active-set")


def answer(problem, gap):
    """Return ``gap`` as a solution, judged as a backend's answer would be."""
    gap = np.asarray(gap, dtype=float)
    verdict = judge(problem, gap, 1e-6)
    solved = cq.solve(problem, "clarabel")
    return replace(solved, run=replace(solved.run, gap=gap), verdict=verdict)


def message_of(function, *arguments, **options):
    with pytest.raises(AssertionError) as caught:
        function(*arguments, **options)
    return str(caught.value)


@pytest.mark.parametrize("name", BACKENDS)
def test_every_backend_encloses_the_exact_solution(name):
    found = cq.solve(CABLE, name, tol=1e-3)
    assert_encloses(found, EXACT)
    assert_encloses(found.certificate, EXACT)


def test_a_gap_outside_is_shown_worst_first_with_its_bound(solution):
    gap = EXACT.copy()
    gap[4] += 0.125
    gap[8] -= 0.25
    lines = message_of(assert_encloses, solution, gap).splitlines()
    assert lines[0] == (
        "gap leaves the bounds of active-set's answer to "
        "Cable(9 nodes, spacing=1, tension=1, load=1, support=2) at 2 of 9 nodes"
    )
    assert lines[1] == "  node 8 (x=9, y=0): gap 0.25 is 0.25 below the lower bound 0.5"
    assert lines[2].startswith("  node 4 (x=5, y=0): gap 0.125 is 0.125 above the upper bound ")
    assert lines[3] == "  expected: lower <= gap <= upper at every node"
    assert "known to within 0.25 only" in lines[5]


def test_at_most_five_nodes_are_shown(solution):
    lines = message_of(assert_encloses, solution, EXACT + 1.0).splitlines()
    assert sum("node " in line and "(x=" in line for line in lines) == 5
    assert lines[6] == "  and 4 more"


def test_a_certificate_alone_knows_no_coordinates(solution):
    text = message_of(assert_encloses, solution.certificate, EXACT + np.where(EXACT > 0, 1.0, 0.5))
    assert text.startswith("gap leaves the bounds at 9 of 9 nodes\n")
    assert "  node 0: gap 1.5 is 1 above the upper bound 0.5" in text


def test_slack_widens_the_bounds_by_as_much_as_it_says(solution):
    assert_encloses(solution, EXACT + 0.125, slack=0.126)
    text = message_of(assert_encloses, solution, EXACT + 0.125, slack=0.124)
    assert "expected: lower - 0.124 <= gap <= upper + 0.124 at every node" in text


def test_what_has_no_bounds_encloses_nothing(solution, monkeypatch):
    monkeypatch.setattr("contactqp.algebra.band.MOST_ENTRIES", 2)
    unproven = cq.solve(ALL_TIED, on_failure="ignore")
    assert "no enclosure is known for such a matrix" in message_of(assert_encloses, unproven, unproven.gap)
    nothing = altered(solution, residuals=None, certificate=None, status=cq.Status.FAILED, termination="singular")
    assert "has no bounds: no finite answer, failed (singular)" in message_of(assert_encloses, nothing, EXACT)
    infinite = replace(solution.certificate, gap_bound=np.inf)
    assert "would enclose any gap" in message_of(assert_encloses, infinite, EXACT)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"certificate": EXACT}, TypeError, "certificate must be a Certificate or a Solution, got ndarray"),
        ({"gap": EXACT[:4]}, ValueError, r"gap must have shape \(9,\), got \(4,\)"),
        ({"gap": np.full(9, np.nan)}, ValueError, "gap must be finite"),
        ({"slack": -1.0}, ValueError, "slack must be >= 0, got -1"),
        ({"slack": "1"}, TypeError, "slack must be a real number"),
    ],
)
def test_bad_arguments_of_assert_encloses(solution, arguments, error, message):
    with pytest.raises(error, match=message):
        assert_encloses(**({"certificate": solution, "gap": EXACT} | arguments))


@pytest.mark.parametrize("name", BACKENDS)
def test_all_backends_have_the_same_contact(solution, name):
    assert assert_same_contact(cq.solve(CABLE, name), solution).all()


def test_undecided_nodes_are_excused():
    touching, hovering = answer(BIACTIVE, [0.5 - 1e-9, 0.0]), answer(BIACTIVE, [0.5 + 1e-9, 2e-9])
    assert touching.contact.tolist() == [False, True]
    assert hovering.contact.tolist() == [False, False]
    assert assert_same_contact(touching, hovering).tolist() == [True, False]


@pytest.mark.parametrize("backend", ["psor", "osqp", "clarabel", "active-set"])
def test_no_assertion_passes_on_an_answer_that_is_not_ok(solution, backend):
    """After one iteration the enclosure is wide, and holds the exact solution all the same."""
    model = cq.gallery.bowl(9)
    exact = cq.solve(model, "active-set")
    early = cq.solve(model, backend, max_iter=1, on_failure="ignore")
    if early.status.ok:
        return
    for assertion in (
        lambda: assert_encloses(early, exact.gap),
        lambda: assert_same_contact(early, exact),
        lambda: assert_same_contact(exact, early),
        lambda: assert_complementary(model, early.gap),
    ):
        with pytest.raises(AssertionError, match=r"iteration_limit|does not solve|no finite answer"):
            assertion()


def test_a_backend_that_returns_zeros_fails_every_assertion():
    class Zeros(Backend):
        """Returns zeros and says that it is done."""

        name, summary, package = "zeros", "returns zeros", "numpy"

        def solve(self, problem, task):
            return Answer(np.zeros(problem.size), Stop.DONE, "done", 1, 0.0, 0.0)

    zeros = cq.solve(CABLE, Zeros(), on_failure="ignore")
    assert "zeros's answer to Cable" in message_of(assert_encloses, zeros, EXACT)
    assert "is inaccurate, bound " in message_of(assert_encloses, zeros, EXACT)
    assert "is inaccurate, bound " in message_of(assert_same_contact, zeros, zeros)
    assert "does not solve" in message_of(assert_complementary, CABLE, zeros.gap)
    assert "zeros (inaccurate: " in message_of(assert_backends_agree, CABLE, [Zeros(), "psor"])


def test_a_small_residual_without_a_proof_does_not_pass(monkeypatch):
    monkeypatch.setattr("contactqp.algebra.band.MOST_ENTRIES", 2)
    text = message_of(assert_complementary, ALL_TIED, [1.0, 0.0, 0.0])
    assert text.startswith("gap is not proven to solve ContactQP(3 unknowns")
    assert "no bound is known for such a matrix; residual 0 of the error scale" in text


def test_contact_that_differs_is_shown_on_both_sides(solution):
    deeper, _ = cq.gallery.cable_on_floor(nodes=9, contact_starts_after=4)
    lines = message_of(assert_same_contact, solution, cq.solve(deeper, "clarabel")).splitlines()
    assert lines[0] == "contact sets differ at 4 of 9 nodes"
    assert lines[1].startswith("  first:  7 in contact, active-set's answer to Cable(9 nodes")
    assert lines[2].startswith("  second: 3 in contact, clarabel's answer to Cable(9 nodes")
    assert lines[3].startswith("  node 1 (x=2, y=0): in contact in the first (gap 0, reaction 0.5), free in the second")
    assert "two problems: their forces q differ at 2 nodes" in lines[-1]


def test_what_makes_two_problems_is_named():
    matrix, q = [[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0]
    held = cq.solve(cq.ContactQP(matrix, q))
    free = cq.solve(cq.ContactQP(matrix, q, supported=[True, False]))
    assert "other nodes have a support" in message_of(assert_same_contact, held, free)
    softer = cq.solve(cq.ContactQP([[2.0, -1.9], [-1.9, 2.0]], q))
    shifted = cq.solve(cq.ContactQP([[0.5, -0.3], [-0.3, 0.19]], [-1.0, 0.5]))
    stiffer = cq.solve(cq.ContactQP([[0.5, -0.1], [-0.1, 0.19]], [-1.0, 0.5]))
    assert assert_same_contact(held, softer).all()
    assert "their matrices differ" in message_of(assert_same_contact, shifted, stiffer)


def test_where_nothing_is_decided_there_is_nothing_to_compare(solution):
    nowhere = np.zeros(9, dtype=bool)
    blind = altered(solution, tol=0.5)
    blind.__dict__["certificate"] = replace(solution.certificate, contact=nowhere, clear=nowhere)
    text = message_of(assert_same_contact, blind, solution)
    assert text == (
        "all 9 nodes are undecided, there is no contact to compare: solve with a smaller tol than 0.5 and 1e-06"
    )
    nothing = altered(solution, residuals=None, certificate=None, status=cq.Status.FAILED, termination="singular")
    assert "has no contact set: no finite answer" in message_of(assert_same_contact, solution, nothing)


def test_other_nodes_are_refused(solution):
    longer, _ = cq.gallery.cable_on_floor(nodes=11, contact_starts_after=2)
    with pytest.raises(ValueError, match="on the same nodes, got 9 and 11 nodes"):
        assert_same_contact(solution, cq.solve(longer))
    finer = cq.solve(cq.Cable(nodes=9, spacing=0.5, tension=1.0, load=1.0, support=0.5))
    with pytest.raises(ValueError, match=r"got node 0 \(x=1, y=0\) and node 0 \(x=0.5, y=0\)"):
        assert_same_contact(solution, finer)
    with pytest.raises(TypeError, match="must be boolean, got dtype float64"):
        assert_same_contact(solution, solution.gap)


def test_a_reference_may_be_wrong_by_its_rounding_and_an_answer_by_what_is_proven_of_it():
    hexagon = cq.gallery.paper_hexagon(load=0.03)
    sharp, rough = cq.solve(hexagon), cq.solve(hexagon, "psor", tol=1e-3)
    assert_encloses(sharp, rough)
    assert_encloses(sharp, sharp.to_dataset()["gap"])
    with pytest.raises(AssertionError, match="above the upper bound"):
        assert_encloses(sharp, sharp.gap + 1e-12)
