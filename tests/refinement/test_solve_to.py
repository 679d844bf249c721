"""Finer and finer lattices until the membrane itself is enclosed: what is reached, how it ends, what it tells."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.refinement.solve_to import interpolated


def bowl(spacing):
    return cq.Membrane(cq.Frame.rectangle(1, 1).lattice(spacing), tension=1.0, load=1.0, support=0.03)


def test_the_membrane_is_enclosed_to_the_tolerance():
    found = cq.solve_to(bowl, 0.03, spacing=1 / 16)
    assert found.reached
    assert len(found.solutions) == 3 - (found.spacing == 1 / 32)
    assert found.continuum.error_bound <= 0.03 * found.solution.verdict.scale
    assert (np.diff(found.relative_bounds) < 0).all()
    table = found.to_frame()
    assert table["spacing"].tolist() == [1 / 16 / 2**k for k in range(len(table))]
    parts = table["algebra"] + table["data"] + table["discretisation"]
    np.testing.assert_allclose(parts, table["error_bound"], rtol=1e-9)
    assert (table["data"] < 1e-9).all()
    assert "tolerance reached" in repr(found)
    told = str(found).splitlines()
    assert max(map(len, told)) <= 80
    assert [line.split()[1] for line in told[2 : 2 + len(table)]] == [str(nodes) for nodes in table["nodes"]]


def test_it_ends_at_limits():
    few = cq.solve_to(bowl, 1e-6, spacing=1 / 8, max_nodes=300)
    assert not few.reached
    assert few.ended == "the next lattice has more than 300 nodes"
    assert few.solution.problem.size == 225
    short = cq.solve_to(bowl, 1e-6, spacing=1 / 8, time_limit=1e-9)
    assert short.ended == "time limit"
    assert len(short.solutions) == 1


def test_a_start_is_the_coarser_answer():
    def tilted(spacing):
        outline = [(0, 0), (1, 0), (1, 0.5), (0.5, 0.5), (0.5, 1), (0, 1)]
        lattice = cq.Frame.polygon(outline).lattice(spacing)
        return cq.Membrane(lattice, 1.0, load=1.0, support=0.2, frame_height=lambda x, y: 0.1 * x - 0.05 * y)

    coarse = cq.solve(tilted(1 / 8), tol=1e-9)
    fine = tilted(1 / 16)
    start = interpolated(fine, coarse)
    depths = {(x, y): d for x, y, d in zip(fine.node_x, fine.node_y, fine.reference - start, strict=True)}
    for x, y, depth in zip(coarse.model.node_x, coarse.model.node_y, coarse.deflection, strict=True):
        assert depths[x, y] == pytest.approx(depth, abs=1e-12)
    assert np.median(np.abs(start - cq.solve(fine, tol=1e-9).gap)) < 0.003


@pytest.mark.parametrize(
    ("function", "error", "words"),
    [
        (3.0, TypeError, "model_of_spacing must be a function that returns a Membrane"),
        (lambda h: 1.0, TypeError, "model_of_spacing must return a Membrane, got 1.0"),
        (lambda h: bowl(h / 2), ValueError, r"model_of_spacing\(0.125\) must return a model of that spacing"),
    ],
)
def test_what_is_no_family_of_lattices_is_refused(function, error, words):
    with pytest.raises(error, match=words):
        cq.solve_to(function, 0.1, spacing=1 / 8)


def test_tolerances_are_checked():
    with pytest.raises(ValueError, match="continuum_tol"):
        cq.solve_to(bowl, 0.0, spacing=1 / 8)
