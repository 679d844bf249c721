"""Derivatives of solutions: by finite differences, by their transposes, and to either side where nodes are biactive."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import contactqp as cq

LATTICE = cq.Frame.rectangle(4, 3).lattice(0.25)


def ground(x, y):
    return 0.1 + 0.05 * x**2 + 0.03 * y + 0.02 * np.sin(3 * x)


def membrane(load=0.3, support=ground, tension=1.0, frame_height=0.0, **more):
    return cq.Membrane(LATTICE, tension, load=load, support=support, frame_height=frame_height, **more)


def turned_over(load=0.3, support=lambda x, y: -ground(x, y), tension=1.0, frame_height=0.0, **more):
    return cq.Membrane(LATTICE, tension, load=load, support=support, frame_height=frame_height, upwards=True, **more)


def between(load=0.0, support=None, ceiling=None, foundation=0.3, tension=1.0, frame_height=0.0):
    load = (lambda x, y: 2.0 * np.sin(1.5 * x)) if np.ndim(load) == 0 and load == 0.0 else load
    support = ground if support is None else support
    ceiling = (lambda x, y: -0.08 - 0.03 * y**2) if ceiling is None else ceiling
    given = {"support": support, "ceiling": ceiling, "foundation": foundation, "frame_height": frame_height}
    return cq.Membrane(LATTICE, tension, load=load, **given)


def cable(load=1.0, support=lambda x: 0.4 + 0.1 * np.sin(x), tension=2.0, frame_height=0.0):
    return cq.Cable(span=10.0, spacing=0.1, tension=tension, load=load, support=support, frame_height=frame_height)


def beam(load=1.0, support=lambda x: 0.4 + 0.1 * np.sin(x), tension=2.0, frame_height=0.0, foundation=0.2):
    given = {"support": support, "frame_height": frame_height, "foundation": foundation, "ends": ("clamped", "pinned")}
    return cq.Beam(span=10.0, spacing=0.25, bending_stiffness=0.7, tension=tension, load=load, **given)


def with_pit(load=0.3, support=None, tension=1.0, frame_height=0.0):
    """A support that is missing in the middle, so that the gap is counted from the frame there."""
    support = (lambda x, y: np.where(np.hypot(x, y) < 0.5, np.inf, ground(x, y))) if support is None else support
    return membrane(load, support, tension, frame_height)


def net(load=0.17, support=0.12, frame_height=0.0):
    points = np.array([[x, y] for y in range(5) for x in range(5)], dtype=float)
    number = np.arange(25).reshape(5, 5)
    ends = (number[:, :-1], number[:, 1:]), (number[:-1], number[1:])
    segments = np.concatenate([np.column_stack([one.ravel(), other.ravel()]) for one, other in ends])
    border = [n for n in range(25) if n // 5 in (0, 4) or n % 5 in (0, 4)]
    return cq.CableNet(
        points, segments, fixed=border, tension=1.0, load=load, support=support, fixed_height=frame_height
    )


MODELS: dict[str, Any] = {
    "membrane": membrane,
    "upwards": turned_over,
    "between": between,
    "cable": cable,
    "beam": beam,
    "pit": with_pit,
    "net": net,
}


def exactly(model):
    return cq.solve(model, "active-set", tol=1e-12, on_failure="ignore")


def values(model, name):
    """Return a parameter of a model as it stands: at the nodes, or a number."""
    if name == "frame_height":
        return 0.0
    value = getattr(model, name)
    return value if np.ndim(value) == 0 else np.array(value)


CASES = [(kind, name) for kind, make in MODELS.items() for name in exactly(make()).sensitivity().parameters]


def direction_of(model, name, seed=0):
    if np.ndim(values(model, name)) == 0:
        return 1.0
    smooth = np.random.default_rng(seed).uniform(0.5, 1.5, model.size)
    return smooth if model.node_area is None else smooth + model.node_x


@pytest.mark.parametrize(("kind", "name"), CASES)
def test_derivatives_are_those_of_finite_differences(kind, name):
    make = MODELS[kind]
    model = make()
    sensitivity = exactly(model).sensitivity()
    assert not sensitivity.biactive.size
    direction, step = direction_of(model, name), 1e-6 if name in ("support", "ceiling", "frame_height") else 1e-5
    value = values(model, name)
    after, before = (exactly(make(**{name: value + sign * step * direction})) for sign in (1, -1))
    assert (after.contact == before.contact).all()
    found = sensitivity.forward(**{name: direction})
    for quantity, told in (("gap", found.gap), ("deflection", found.deflection), ("reaction", found.reaction)):
        difference = (getattr(after, quantity) - getattr(before, quantity)) / (2 * step)
        np.testing.assert_allclose(
            told, difference, rtol=1e-5, atol=1e-9 + 1e-5 * np.abs(difference).max(), err_msg=quantity
        )
    total = (after.reaction.sum() - before.reaction.sum()) / (2 * step)
    assert found.total_reaction == pytest.approx(total, rel=1e-6, abs=1e-6 * np.abs(found.reaction).max())


@pytest.mark.parametrize("kind", MODELS)
def test_gradients_are_the_transposes_of_derivatives(kind):
    rng = np.random.default_rng(1)
    model = MODELS[kind]()
    sensitivity = exactly(model).sensitivity()
    weights = {name: rng.normal(size=model.size) for name in ("gap", "deflection", "reaction")}
    gradient = sensitivity.adjoint(**weights)
    assert set(gradient) == set(sensitivity.parameters)
    for name, by in gradient.items():
        direction = rng.normal(size=np.shape(by)) if np.ndim(by) else float(rng.normal())
        change = sensitivity.forward(**{name: direction})
        told = sum(float(weights[quantity] @ getattr(change, quantity)) for quantity in weights)
        parts = sum(float(np.abs(weights[quantity]) @ np.abs(getattr(change, quantity))) for quantity in weights)
        assert np.sum(by * direction) == pytest.approx(told, rel=1e-9, abs=1e-10 * parts)


def test_a_beam_without_tension_has_a_derivative_by_it():
    tensions = 0.0, 1e-5
    free, stretched = (exactly(beam(tension=tension)) for tension in tensions)
    change = free.sensitivity().forward(tension=1.0).deflection
    difference = (stretched.deflection - free.deflection) / tensions[1]
    np.testing.assert_allclose(change, difference, rtol=1e-3, atol=1e-4 * np.abs(difference).max())


def test_directions_add_up():
    sensitivity = exactly(membrane()).sensitivity()
    together = sensitivity.forward(load=1.0, support=0.1, tension=-0.5)
    apart = [sensitivity.forward(load=1.0), sensitivity.forward(support=0.1), sensitivity.forward(tension=-0.5)]
    np.testing.assert_allclose(together.gap, sum(each.gap for each in apart), atol=1e-12)


def test_support_and_frame_together_move_a_membrane_without_a_force():
    """A membrane that is moved as a whole, with its frame, feels nothing of it."""
    sensitivity = exactly(membrane()).sensitivity()
    lifted = sensitivity.forward(support=1.0, frame_height=1.0)
    np.testing.assert_allclose(lifted.gap, 0.0, atol=1e-9)
    np.testing.assert_allclose(lifted.deflection, 1.0, atol=1e-9)
    np.testing.assert_allclose(lifted.reaction, 0.0, atol=1e-9)


@given(seed=st.integers(0, 2000), size=st.integers(2, 7))
def test_bare_problems_by_forces_and_both_bounds(seed, size):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(size, size))
    matrix = root @ root.T + np.eye(size)
    q, lower, upper = rng.normal(size=size), -rng.uniform(0, 1, size), rng.uniform(0, 1, size)

    def solved(q, lower, upper):
        return cq.solve(cq.ContactQP(matrix, q, lower, upper), "active-set", tol=1e-12, on_failure="ignore")

    solution = solved(q, lower, upper)
    held = solution.contact
    if (np.abs(solution.reaction[held]) < 1e-3).any() or (
        np.minimum(solution.gap - lower, upper - solution.gap)[~held] < 1e-3
    ).any():
        return  # near a change of the contact set
    directions = {name: rng.normal(size=size) for name in ("q", "lower", "upper")}
    found = solution.sensitivity().forward(**directions)
    ends = [
        solved(
            *(value + sign * 1e-6 * directions[name] for name, value in zip(directions, (q, lower, upper), strict=True))
        )
        for sign in (1, -1)
    ]
    np.testing.assert_allclose(found.gap, (ends[0].gap - ends[1].gap) / 2e-6, atol=1e-6 * (1 + np.abs(found.gap).max()))
    weights = rng.normal(size=size)
    gradient = solution.sensitivity().adjoint(gap=weights)
    assert sum(gradient[name] @ directions[name] for name in directions) == pytest.approx(
        weights @ found.gap, rel=1e-9, abs=1e-9
    )


def test_matrices_that_are_not_symmetric():
    matrix = np.diag(np.full(5, 3.0)) - np.diag(np.full(4, 2.0), -1) - np.diag(np.full(4, 0.5), 1)
    q = np.array([-3.0, -1.0, 2.0, 3.0, -1.0])
    sensitivity = cq.solve(cq.ContactLCP(matrix, q), tol=1e-9).sensitivity()
    direction = np.array([1.0, -1.0, 0.5, 0.2, 0.3])
    ends = [cq.solve(cq.ContactLCP(matrix, q + sign * 1e-6 * direction), tol=1e-12).gap for sign in (1, -1)]
    found = sensitivity.forward(q=direction)
    np.testing.assert_allclose(found.gap, (ends[0] - ends[1]) / 2e-6, atol=1e-7)
    weights = np.arange(5.0)
    assert sensitivity.adjoint(gap=weights)["q"] @ direction == pytest.approx(weights @ found.gap)


def test_biactive_nodes_have_one_sided_derivatives():
    """The node touches the floor and nothing presses: it lifts with a force one way, and stays with the other."""
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 0.5])
    solution = cq.solve(problem, tol=1e-9)
    np.testing.assert_allclose(solution.gap, [0.5, 0.0], atol=1e-12)
    sensitivity = solution.sensitivity()
    assert sensitivity.biactive.tolist() == [1]
    np.testing.assert_allclose(sensitivity.forward(q=[0.0, 1.0]).gap, [0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(sensitivity.forward(q=[0.0, -1.0]).gap, np.array([1.0, 2.0]) / 3, atol=1e-9)
    np.testing.assert_allclose(sensitivity.forward(q=[0.0, 1.0]).reaction, [0.0, 1.0], atol=1e-9)
    with pytest.raises(ValueError, match=r"no gradient: 1 node \(first node 1\)"):
        sensitivity.adjoint(gap=1.0)


def test_what_cannot_be_is_said():
    sensitivity = exactly(membrane()).sensitivity()
    with pytest.raises(TypeError, match="no parameter 'loads'; give load, support"):
        sensitivity.forward(loads=1.0)
    with pytest.raises(TypeError, match="at least: load"):
        sensitivity.forward()
    with pytest.raises(ValueError, match="shape"):
        sensitivity.forward(load=np.ones(3))
    bare = cq.solve(membrane().problem, tol=1e-9).sensitivity()
    with pytest.raises(TypeError, match="no deflection"):
        bare.adjoint(deflection=1.0)


def test_a_loose_answer_is_finished_first():
    solution = cq.solve(membrane(), "psor", tol=1e-2)
    sensitivity = solution.sensitivity()
    assert sensitivity.solution.relative_bound < 1e-8
    fine = exactly(membrane()).sensitivity()
    np.testing.assert_allclose(sensitivity.forward(load=1.0).gap, fine.forward(load=1.0).gap, atol=1e-9)


@pytest.mark.slow
def test_large_lattices_are_differentiated_by_multigrid():
    solution = cq.solve(cq.gallery.bowl(127), tol=1e-9)
    sensitivity = solution.sensitivity()
    weights = np.random.default_rng(0).normal(size=solution.problem.size)
    load = np.ones(solution.problem.size)
    change = sensitivity.forward(load=load)
    assert sensitivity.adjoint(gap=weights)["load"] @ load == pytest.approx(weights @ change.gap, rel=1e-8)
