"""MembraneByRows: rows of its fields, and what it refuses."""

import numpy as np
import pytest

import contactqp as cq


def membrane(**given):
    arguments = {"load": 1.0, "support": 0.5, "tension": 1.0, **given}
    return cq.mpi.MembraneByRows((4, 3), 0.5, arguments.pop("tension"), **arguments)


def test_functions_and_arrays_are_read_row_by_row():
    asked = []

    def load(x, y):
        asked.append((x.tolist(), y.tolist()))
        return x + 10 * y

    grid = np.arange(12.0).reshape(4, 3)
    model = membrane(load=load, support=grid, mask=lambda x, y: x + y < 2.2, origin=(1.0, 0.0))
    np.testing.assert_array_equal(model.nodes(1, 3), [[True, True, False], [True, False, False]])
    np.testing.assert_array_equal(model.rows_of("load", 1, 3), [[6.0, 6.5, 0.0], [11.0, 0.0, 0.0]])
    assert asked == [([1.0, 1.5], [0.5, 0.5]), ([1.0], [1.0])]
    np.testing.assert_array_equal(model.rows_of("support", 1, 2), [[3.0, 4.0, 0.0]])


def test_heights_upwards_are_returned_as_depths():
    model = membrane(support=cq.profiles.Plane(depth=0.25), ceiling=np.inf, upwards=True)
    assert (model.rows_of("support", 0, 4) == 0.25).all()
    assert (model.rows_of("ceiling", 0, 4) == -np.inf).all()
    assert (membrane(support=-0.25, upwards=True).rows_of("support", 0, 4) == 0.25).all()


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"load": np.zeros((3, 4))}, r"load must be .* shape \(4, 3\), got \(3, 4\)"),
        ({"support": np.zeros(12)}, r"support must be .* got \(12,\)"),
        ({"frame_height": np.inf}, "frame_height"),
        ({"upwards": 1}, "upwards"),
        ({"foundation": np.zeros((2, 2))}, r"foundation must be .* shape \(4, 3\), got \(2, 2\)"),
        ({"tension": np.ones((4, 4))}, r"tension must be .* shape \(4, 3\), got \(4, 4\)"),
        ({"tension": (1.0, 2.0, 3.0)}, "tension must be .* got a tuple of 3"),
        ({"tension": -1.0}, "tension must be"),
    ],
)
def test_wrong_arguments_are_refused(given, told):
    with pytest.raises((ValueError, TypeError), match=told):
        membrane(**given)


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("load", lambda x, y: np.where(y > 0.7, np.nan, 1.0), "load must be finite, but is nan at x=0, y=1"),
        ("support", lambda x, y: -np.inf * np.ones_like(x), r"finite or \+inf \(no support\), but is -inf"),
        ("ceiling", np.inf, r"finite or -inf \(no ceiling\), but is inf"),
        ("foundation", lambda x, y: 1.0 - x, "foundation must be finite and >= 0, but is -0.5 at x=1.5, y=0"),
    ],
)
def test_wrong_values_are_told_with_their_place(name, value, told):
    with pytest.raises(ValueError, match=told):
        membrane(**{name: value}, origin=(0.5, 0.0) if name == "foundation" else (0.0, 0.0)).rows_of(name, 0, 4)


MASK = np.array([[False, True, False], [True, True, True], [True, True, False], [False, True, True]])
FRAYED = np.array([[np.nan, 2.0, 3.0], [1.0, 4.0, 2.0], [5.0, 1.0, np.nan], [0.5, 3.0, 2.5]])


@pytest.mark.parametrize("tension", [lambda x, y: 1.0 + x * y, FRAYED, (FRAYED, lambda x, y: 2.0 + x), (2.0, FRAYED)])
def test_arms_are_those_of_a_membrane(tension):
    """Of all rows, and of windows of some."""
    model = membrane(tension=tension, mask=MASK, origin=(1.0, 0.25))
    lattice = cq.Lattice.from_mask(MASK, 0.5, (1.0, 0.25))
    stencil = cq.Membrane(lattice, tension, load=1.0, support=0.5).stencil
    nodes = np.pad(MASK, 1)
    for first, last in ((0, 4), (1, 3)):
        window = nodes[first : last + 2]
        for axis, arms in (("x", stencil.horizontal), ("y", stencil.vertical)):
            found = model.arms(axis, first - 1, -1, window)
            ends = (window[1:-1, :-1] | window[1:-1, 1:]) if axis == "x" else (window[:-1, 1:-1] | window[1:, 1:-1])
            wanted = arms if arms.ndim == 0 else arms[first : last + (axis == "y")]
            np.testing.assert_array_equal(np.where(ends, found, 0.0), np.where(ends, wanted, 0.0))


@pytest.mark.parametrize(
    ("tension", "told"),
    [
        (lambda x, y: x - 0.3, "tension must be finite and > 0, but is -0.55 on the arm about x=-0.25, y=0"),
        (np.where(MASK, np.inf, 1.0), "tension must be finite and > 0"),
        (np.where(np.eye(4, 3) > 0, -1.0, 1.0), "tension must be finite and > 0, but is -1 on"),
        (np.where(MASK, np.nan, 1.0), "tension must be finite and > 0, but is 0 on"),
    ],
)
def test_wrong_tensions_are_told_with_their_place(tension, told):
    model = membrane(tension=tension)
    nodes = np.pad(np.ones((4, 3), dtype=bool), 1)
    with pytest.raises(ValueError, match=told):
        model.arms("x", -1, -1, nodes)


def test_the_frame_has_heights_where_it_holds_arms():
    heights = np.arange(12.0).reshape(4, 3)
    inner = np.zeros((4, 3), dtype=bool)
    inner[1:3, 1] = True
    model = membrane(frame_height=heights, mask=inner)
    found = model.frame_depths(0, 0, inner)
    held = np.array([[0, 1, 0], [1, 0, 1], [1, 0, 1], [0, 1, 0]])
    np.testing.assert_array_equal(found, np.where(held, heights, np.nan))
    upside_down = membrane(frame_height=lambda x, y: x + y, mask=inner, upwards=True)
    np.testing.assert_array_equal(upside_down.frame_depths(0, 0, inner)[:, 1], [-0.5, np.nan, np.nan, -2.0])
    assert membrane(frame_height=0.5).frame_depths(0, 0, inner) == 0.5
    with pytest.raises(ValueError, match=r"frame_height must be finite .* x=0, y=-0.5; pass a function"):
        membrane(frame_height=heights).frame_depths(-1, -1, np.pad(np.ones((4, 3), dtype=bool), 1))


def test_other_models_are_refused_in_words(tmp_path):
    pytest.importorskip("mpi4py")
    lattice = cq.Lattice.from_mask(np.ones((4, 3), dtype=bool), 0.5)
    model = cq.Membrane(lattice, 1.0, load=1.0, support=0.5)
    for refused in (lambda: cq.mpi.solve(model), lambda: cq.mpi.trace(model, [1.0], tmp_path)):
        with pytest.raises(TypeError, match="membrane must be a contactqp"):
            refused()


def test_a_mask_is_of_yes_and_no():
    with pytest.raises(TypeError, match="must return True or False"):
        membrane(mask=lambda x, y: x).nodes(0, 1)
    with pytest.raises(TypeError, match="must be boolean"):
        membrane(mask=np.ones((4, 3))).nodes(0, 1)


def test_one_process_holds_few_rows_as_well():
    pytest.importorskip("mpi4py")
    support = np.where(np.eye(4, 3) > 0, np.inf, 0.5)
    answer = cq.mpi.solve(membrane(load=10.0, support=support), max_iter=50)
    assert (answer.status.value, answer.rows) == ("certified", (0, 4))
    lattice = cq.Lattice.from_mask(np.ones((4, 3), dtype=bool), 0.5)
    solution = cq.solve(cq.Membrane(lattice, 1.0, load=10.0, support=support))
    np.testing.assert_allclose(answer.deflection.ravel(), solution.deflection, atol=1e-6)
    assert "certified, multigrid of 1 process, " in answer.summary()


def test_limits_are_told():
    pytest.importorskip("mpi4py")
    model = cq.mpi.MembraneByRows((40, 40), 0.025, 1.0, load=1.0, support=lambda x, y: 0.01 + x * y)
    answer = cq.mpi.solve(model, tol=1e-10, max_iter=1)
    assert answer.status.value == "iteration_limit"
    assert "ended       cycle limit after 1 cycle" in answer.summary()
    assert cq.mpi.solve(model, tol=1e-12, time_limit=1e-6).status.value == "time_limit"
