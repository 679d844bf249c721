"""What is wrong with an argument is told by its name, its value and what to do."""

import numpy as np
import pytest
from scipy.sparse import csr_array

import contactqp as cq

G, Q = [[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0]
LATTICE = cq.Frame.rectangle(4, 4).lattice(spacing=1.0)


def membrane(load=1.0, support=0.9, **more):
    return cq.Membrane(LATTICE, tension=1.0, load=load, support=support, **more)


def failing(x, y):
    raise RuntimeError("no data here")


@pytest.mark.parametrize(
    ("call", "error", "told"),
    [
        (lambda: cq.trace(membrane(), loads=0.1), TypeError, r"loads must be a sequence .* \[1.0, 2.0\], got 0.1"),
        (lambda: cq.trace(membrane(), loads="x"), TypeError, "loads must be a sequence .*, got 'x'"),
        (lambda: cq.trace(membrane(), lifts=[]), ValueError, "lifts must be a sequence .*, got none"),
        (lambda: cq.trace(membrane(), loads=[0.1, 0.2, 0.1]), ValueError, "repeat a value, but 0.1 is there 2 times"),
        (lambda: cq.ContactQP([[1, 2], [3]], Q), ValueError, r"G must .* rows of one length, got \[\[1, 2\], \[3\]\]"),
        (lambda: cq.ContactQP(None, Q), TypeError, "G must hold real numbers, got None"),
        (lambda: cq.ContactQP("x", Q), TypeError, "G must hold real numbers, got 'x'"),
        (lambda: cq.ContactQP(G, "x"), TypeError, "q must hold real numbers, got 'x'"),
        (lambda: cq.ContactQP(G, Q, upper="x"), TypeError, "upper must hold real numbers, got 'x'"),
        (lambda: cq.ContactQP(G, csr_array([Q])), TypeError, r"q must be a dense .* \(1, 2\); .* q.toarray\(\).ravel"),
        (lambda: cq.ContactQP(G, Q, lower=csr_array([Q]).T), TypeError, r"over lower.toarray\(\).ravel\(\)"),
        (lambda: cq.ContactQP(G, np.array([Q]).T), ValueError, r"q must .* got \(2, 1\); hand over q.ravel\(\)"),
        (lambda: cq.ContactQP(G, Q, upper=np.array([Q])), ValueError, r"upper must .*\(1, 2\); hand over upper.rav"),
        (lambda: cq.solve(membrane()).save(None), TypeError, "path must be the name of a file, as .*, got None"),
        (lambda: cq.study("cable-on-foundation", "9,19"), TypeError, r"sizes must be .*, as \[31, 63\], got '9,19'"),
        (lambda: cq.certify(cq.ContactQP(G, Q), {}), TypeError, "gap must hold real numbers, got {}"),
        (lambda: membrane(load=lambda x: x), TypeError, r"load must be a function of x and y, but <lambda>\(x\)"),
        (lambda: membrane(support=lambda x: x), TypeError, "support must be a function of x and y"),
        (lambda: membrane(frame_height=lambda x: x), TypeError, "frame_height must be a function of x and y"),
        (lambda: cq.Frame.polygon([(0, 0), (1, 1), (2, 2)]), ValueError, r"corners must enclose .* one line, from \(0"),
        (lambda: cq.Frame.polygon([(1, 1)] * 3), ValueError, "corners must enclose an area"),
        (lambda: cq.Frame.polygon([(0, 0), (9, 0), (0, 9)], [[(1, 1), (2, 2), (3, 3)]]), ValueError, r"holes\[0\]"),
        (lambda: cq.solve(membrane()).plot("."), TypeError, "ax must be axes of matplotlib, got '.'"),
        (lambda: cq.solve(membrane()).report("."), ValueError, "on_failure must be one of .*, got '.'"),
        (lambda: cq.solve(membrane(), relaxation=1.5), TypeError, "'relaxation'.*'auto' chose it, 9 unknowns are few;"),
    ],
)  # fmt: skip
def test_argument_value_and_remedy_are_told(call, error, told):
    with pytest.raises(error, match=told):
        call()


@pytest.mark.parametrize("argument", ["load", "support", "frame_height"])
def test_a_function_that_raises_is_called_by_its_argument(argument):
    with pytest.raises(RuntimeError, match="no data here") as caught:
        membrane(**{argument: failing})
    assert f"the function that was given as {argument}" in caught.value.__notes__[0]


def test_thin_polygons_are_no_lines():
    assert cq.Frame.polygon([(0.0, 0.0), (1e3, 0.0), (1e3, 1e-3)]).area == pytest.approx(0.5)
    assert np.isclose(cq.Frame.polygon([(1e6, 1e6), (1e6 + 1, 1e6), (1e6, 1e6 + 1)]).area, 0.5)
