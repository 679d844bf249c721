"""MembraneByRows: rows of its fields, and what it refuses."""

import numpy as np
import pytest

import contactqp as cq


def membrane(**given):
    arguments = {"load": 1.0, "support": 0.5, **given}
    return cq.mpi.MembraneByRows((4, 3), 0.5, 1.0, **arguments)


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
    ],
)
def test_wrong_values_are_told_with_their_place(name, value, told):
    with pytest.raises(ValueError, match=told):
        membrane(**{name: value}).rows_of(name, 0, 4)


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
