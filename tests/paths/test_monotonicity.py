"""Findings of a load path: what contradicts monotonicity, and what is no more than rounding."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import contactqp as cq
from contactqp.paths.monotonicity import _rounding_of_data


@pytest.fixture(scope="module")
def lifted():
    return cq.trace(cq.gallery.paper_hexagon(0.05), lifts=np.linspace(-0.5, 0.5, 11))


def test_rounding_of_the_data_is_no_violation(lifted):
    """Nodes that contact nodes surround have the same gap at every lift, but for the rounding of q."""
    certificates = [solution.certificate for solution in lifted.solutions]
    growth = max(float((later.lower - earlier.upper).max()) for earlier, later in pairwise(certificates))
    assert 0 < growth < 1e-14
    assert lifted.findings == ()
    assert lifted.verdict == "no violation of monotonicity"


def test_growth_beyond_rounding_is_a_finding(lifted):
    noise = float(_rounding_of_data(lifted.model, lifted.solutions[0], abs(lifted.values[0])).max())
    assert 1e-13 < noise < 1e-10
    backwards = replace(lifted, solutions=lifted.solutions[::-1])
    assert len(backwards.findings) == 20
    assert "node(s) lift off between lift" in backwards.findings[1]
    assert backwards.verdict == f"{backwards.findings[0]}; and 19 more findings"
    assert repr(backwards).endswith(backwards.verdict)
    assert replace(backwards, values=lifted.values[:2], solutions=backwards.solutions[:2]).verdict.endswith(
        "; and 1 more finding"
    )


def test_the_title_of_a_picture_is_no_wider_than_the_picture(lifted):
    figure = replace(lifted, solutions=lifted.solutions[::-1]).plot()
    figure.draw_without_rendering()
    extent = figure._suptitle.get_window_extent()
    assert extent.x0 >= 0
    assert extent.x1 <= figure.bbox.width
