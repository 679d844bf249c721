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


def beam(
    load=1.0,
    support=lambda x: 0.4 + 0.1 * np.sin(x),
    tension=2.0,
    frame_height=0.0,
    foundation=0.2,
    bending_stiffness=0.7,
):
    given = {"support": support, "frame_height": frame_height, "foundation": foundation, "ends": ("clamped", "pinned")}
    return cq.Beam(span=10.0, spacing=0.25, bending_stiffness=bending_stiffness, tension=tension, load=load, **given)


def with_pit(load=0.3, support=None, tension=1.0, frame_height=0.0):
    """A support that is missing in the middle, so that the gap is counted from the frame there."""
    support = (lambda x, y: np.where(np.hypot(x, y) < 0.5, np.inf, ground(x, y))) if support is None else support
    return membrane(load, support, tension, frame_height)


def net(load=0.17, support=0.12, frame_height=0.0, tension=1.0):
    points = np.array([[x, y] for y in range(5) for x in range(5)], dtype=float)
    number = np.arange(25).reshape(5, 5)
    ends = (number[:, :-1], number[:, 1:]), (number[:-1], number[1:])
    segments = np.concatenate([np.column_stack([one.ravel(), other.ravel()]) for one, other in ends])
    border = [n for n in range(25) if n // 5 in (0, 4) or n % 5 in (0, 4)]
    return cq.CableNet(
        points, segments, fixed=border, tension=tension, load=load, support=support, fixed_height=frame_height
    )


def plate(load=300.0, support=0.5, tension=2.0, frame_height=0.0, bending_stiffness=1.0):
    given = {"support": support, "tension": tension, "frame_height": frame_height, "load": load}
    return cq.Plate(cq.Frame.rectangle(1.5, 1).lattice(0.125), bending_stiffness, **given)


MODELS: dict[str, Any] = {
    "membrane": membrane,
    "upwards": turned_over,
    "between": between,
    "cable": cable,
    "beam": beam,
    "plate": plate,
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


ARMS = ("arms_x", "arms_y")
POINTS = ("frame_heights", "fixed_height")
STIFF = ("point_stiffness",)
CASES = [
    (kind, name)
    for kind, make in MODELS.items()
    for name in exactly(make()).sensitivity().parameters
    if name not in ARMS + POINTS + STIFF  # no arguments that these are made from
]


def direction_of(model, name, seed=0):
    if np.ndim(values(model, name)) == 0:
        return 1.0
    smooth = np.random.default_rng(seed).uniform(0.5, 1.5, values(model, name).shape)
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
        np.testing.assert_allclose(told, difference, rtol=1e-6, atol=1e-6 * np.abs(told).max() + 1e-9, err_msg=quantity)
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


@pytest.mark.parametrize(
    ("kind", "tension"),
    [("membrane", 1.0), ("upwards", 1.0), ("between", lambda x, y: 1.0 + 0.2 * x), ("pit", (1.5, 0.8)), ("cable", 2.0)],
)
def test_derivatives_by_the_tension_of_each_arm(kind, tension):
    """A function is evaluated in the middle of each arm, so that differences by it are those by the arms."""
    own = tension if isinstance(tension, tuple) else (tension, tension)
    ways = (lambda x, y: 1 + 0.3 * np.sin(x) + 0.1 * y), (lambda x, y: 0.5 + 0.2 * np.cos(2 * y))

    def with_step(step):
        def part(base, way):
            return lambda x, y: (base(x, y) if callable(base) else base) + step * way(x, y)

        parts = tuple(part(base, way) for base, way in zip(own, ways, strict=True))
        return MODELS[kind](tension=parts[0] if kind == "cable" else parts)

    model = with_step(0.0)
    fields = zip(with_step(1.0).tension_of_arms.fields, model.tension_of_arms.fields, strict=True)
    directions = {
        name: np.asarray(one.arms) - np.asarray(none.arms) for name, (one, none) in zip(ARMS, fields, strict=False)
    }
    after, before = (exactly(with_step(sign * 1e-5)) for sign in (1, -1))
    assert (after.contact == before.contact).all()
    sensitivity = exactly(model).sensitivity()
    found = sensitivity.forward(**directions)
    for quantity in ("gap", "deflection", "reaction"):
        difference = (getattr(after, quantity) - getattr(before, quantity)) / 2e-5
        np.testing.assert_allclose(
            getattr(found, quantity), difference, rtol=1e-6, atol=1e-6 * np.abs(difference).max() + 1e-9
        )
    gradient = sensitivity.adjoint(reaction=1.0, by=tuple(directions))
    assert set(gradient) == set(directions)
    told = sum(float((gradient[name] * directions[name]).sum()) for name in directions)
    assert told == pytest.approx(found.total_reaction, rel=1e-9)


def test_one_tension_is_that_of_all_arms():
    sensitivity = exactly(membrane()).sensitivity()
    gradient = sensitivity.adjoint(gap=1.0)
    assert gradient["arms_x"].shape == (LATTICE.shape[0], LATTICE.shape[1] + 1)
    assert gradient["arms_y"].shape == (LATTICE.shape[0] + 1, LATTICE.shape[1])
    assert gradient["arms_x"].sum() + gradient["arms_y"].sum() == pytest.approx(gradient["tension"])
    together = sensitivity.forward(arms_x=1.0, arms_y=1.0)
    np.testing.assert_allclose(together.gap, sensitivity.forward(tension=1.0).gap, atol=1e-9)
    with pytest.raises(ValueError, match=r"arms_x must be a number or have shape \(13, 18\), got \(3,\)"):
        sensitivity.forward(arms_x=np.ones(3))
    with pytest.raises(TypeError, match="no parameter 'arms'; give load"):
        sensitivity.adjoint(gap=1.0, by="arms")


@pytest.mark.parametrize("kind", ["membrane", "upwards", "between", "pit", "cable", "net"])
def test_derivatives_by_the_height_of_each_point_of_the_frame(kind):
    """Where there is no support the gap counts from the frame's mean height, which the points move as well."""

    def tilted(x, y=0.0):
        return 0.5 + 0.3 * x - 0.2 * y

    def with_step(step):
        return MODELS[kind](frame_height=lambda x, y=0.0: step * tilted(x, y))

    model, name = with_step(0.0), "fixed_height" if kind == "net" else "frame_heights"
    after, before = (exactly(with_step(sign * 1e-6)) for sign in (1, -1))
    direction = getattr(after.model, name) / 1e-6
    assert (after.contact == before.contact).all()
    sensitivity = exactly(model).sensitivity()
    found = sensitivity.forward(**{name: direction})
    for quantity in ("gap", "deflection", "reaction"):
        difference = (getattr(after, quantity) - getattr(before, quantity)) / 2e-6
        told = getattr(found, quantity)
        np.testing.assert_allclose(told, difference, rtol=1e-6, atol=1e-6 * np.abs(told).max() + 1e-9)
    gradient = sensitivity.adjoint(gap=model.node_x, reaction=1.0)
    told = float(model.node_x @ found.gap) + found.total_reaction
    assert float((gradient[name] * direction).sum()) == pytest.approx(told, rel=1e-9, abs=1e-9)
    assert gradient[name].sum() == pytest.approx(gradient["frame_height"], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("ends", [("clamped", "pinned"), ("free", "clamped"), ("pinned", "free")])
def test_derivatives_by_the_stiffness_of_each_point_of_a_beam(ends):
    given = {"spacing": 0.25, "tension": 0.5, "load": 1.0, "support": 0.4, "foundation": 0.2, "ends": ends}
    points = 41

    def stiff(step):
        return 0.7 + step * (1 + np.sin(np.arange(points)))

    after, before = (exactly(cq.Beam(10.0, bending_stiffness=stiff(step), **given)) for step in (1e-5, -1e-5))
    sensitivity = exactly(cq.Beam(10.0, bending_stiffness=stiff(0.0), **given)).sensitivity()
    direction = stiff(1.0) - stiff(0.0)
    found = sensitivity.forward(point_stiffness=direction)
    for quantity in ("gap", "deflection", "reaction"):
        difference = (getattr(after, quantity) - getattr(before, quantity)) / 2e-5
        told = getattr(found, quantity)
        np.testing.assert_allclose(told, difference, rtol=1e-5, atol=1e-6 * np.abs(told).max())
    gradient = sensitivity.adjoint(reaction=1.0, by="point_stiffness")["point_stiffness"]
    assert float(gradient @ direction) == pytest.approx(found.total_reaction, rel=1e-9)


def test_a_gradient_of_nothing_is_asked_for_its_weights():
    with pytest.raises(TypeError, match=r"gap=, deflection= or reaction=: reaction=1\.0 is the total reaction"):
        exactly(cable()).sensitivity().adjoint()


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
    with pytest.raises(ValueError, match=r"no gradient: 1 node \(first unknown 1\)"):
        sensitivity.adjoint(gap=1.0)


def admissible_to_first_order(sensitivity, found, lower=0.0, upper=0.0):
    """Assert that no biactive node leaves its bound, or is pulled by it, as gap and reaction begin to change."""
    problem, nodes = sensitivity.solution.problem, sensitivity.biactive
    lower, upper = (np.broadcast_to(moved, problem.size)[nodes] for moved in (lower, upper))
    gap, reaction, place = found.gap[nodes], found.reaction[nodes], sensitivity.solution.gap[nodes]
    at_lower, at_upper = place - problem.lower[nodes] < 1e-9, problem.upper[nodes] - place < 1e-9
    assert (at_lower != at_upper).all()
    room = np.where(at_lower, gap - lower, upper - gap)
    push = np.where(at_lower, reaction, -reaction)
    assert (room >= 0).all()
    assert (push >= 0).all()
    assert (room * push == 0).all()


def test_an_unloaded_membrane_is_not_pressed_through_its_support():
    """The membrane hangs straight between the frame's sides, and the support meets it at the frame only."""
    hexagon = cq.gallery.paper_hexagon()
    unloaded = cq.Membrane(hexagon.lattice, hexagon.tension, load=0.0, support=hexagon.support)
    sensitivity = cq.solve(unloaded, tol=1e-9).sensitivity()
    touching = np.array(unloaded.support) < 1e-12
    assert touching.any()
    assert sensitivity.biactive.tolist() == np.flatnonzero(touching).tolist()
    pressed = sensitivity.forward(load=1.0)
    np.testing.assert_array_equal(pressed.gap[touching], 0.0)
    assert (pressed.gap[~touching] < 0).all()
    admissible_to_first_order(sensitivity, pressed)
    held = exactly(cq.Membrane(hexagon.lattice, hexagon.tension, load=1e-6, support=hexagon.support))
    np.testing.assert_allclose(pressed.gap, (held.gap - unloaded.support) / 1e-6, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(pressed.reaction[touching], held.reaction[touching] / 1e-6, rtol=1e-5)
    lifted = sensitivity.forward(load=-1.0)
    assert (lifted.gap > 0).all()
    np.testing.assert_array_equal(lifted.reaction, 0.0)
    with pytest.raises(ValueError, match="no gradient"):
        sensitivity.adjoint(gap=1.0)


@pytest.mark.parametrize(
    ("support", "frame_height"),
    [
        (0.0, 0.0),
        (lambda x: np.where(np.sin(9 * x) > 0, 3.0, np.nextafter(3.0, 4.0)), 3.0),
        (lambda x: 0.3 * (x - 5) ** 2 * (np.abs(x - 5) > 1.5), 0.0),
    ],
    ids=["level", "level but for rounding", "in the middle"],
)
def test_an_unloaded_cable_is_not_pressed_through_its_support(support, frame_height):
    unloaded = cable(load=0.0, support=support, frame_height=frame_height)
    sensitivity = cq.solve(unloaded, tol=1e-9).sensitivity()
    touching = np.abs(np.array(unloaded.support) - frame_height) < 1e-12
    assert sensitivity.biactive.tolist() == np.flatnonzero(touching).tolist()
    pressed, lifted = sensitivity.forward(load=1.0), sensitivity.forward(load=-1.0)
    np.testing.assert_array_equal(pressed.gap[touching], 0.0)
    assert (pressed.reaction[touching] > 0).all()
    assert (lifted.gap > 0).all()
    np.testing.assert_array_equal(lifted.reaction, 0.0)


def test_a_membrane_that_barely_touches_a_ceiling():
    """Free of everything, the membrane lies as its load bends it; the ceiling has exactly that shape."""
    free = exactly(membrane(support=9.0))
    under = membrane(support=9.0, ceiling=free.deflection)
    sensitivity = cq.solve(under, tol=1e-9).sensitivity()
    assert sensitivity.biactive.size == under.size
    lifted, pressed = sensitivity.forward(load=-1.0), sensitivity.forward(load=1.0)
    np.testing.assert_array_equal(lifted.gap, 0.0)
    np.testing.assert_allclose(lifted.reaction, -under.node_area, rtol=1e-9)
    assert (pressed.gap < 0).all()
    np.testing.assert_array_equal(pressed.reaction, 0.0)
    for load in (1.0, -1.0):
        admissible_to_first_order(sensitivity, sensitivity.forward(load=load))


def test_forces_that_balance_exactly_are_no_contact():
    """The support has the shape that the load gives to the cable: whatever rounding leaves is no side."""
    free = exactly(cable(support=99.0))
    sensitivity = cq.solve(cable(support=free.deflection), tol=1e-9).sensitivity()
    assert sensitivity.biactive.size == sensitivity.solution.problem.size
    np.testing.assert_array_equal(sensitivity.forward(load=1.0).gap, 0.0)
    np.testing.assert_allclose(sensitivity.forward(load=1.0).reaction, 0.1)
    assert (sensitivity.forward(load=-1.0).gap > 0).all()
    by_proof_alone = cq.solve(cable(support=free.deflection), tol=1e-9).sensitivity(tolerance=0.0)
    assert by_proof_alone.biactive.size < sensitivity.biactive.size
    with pytest.raises(ValueError, match="tolerance"):
        cq.solve(cable()).sensitivity(tolerance=-1.0)


def test_a_node_that_is_shut_between_its_bounds_moves_with_them():
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 0.5], [0.0, 0.0], [np.inf, 0.0])
    sensitivity = cq.solve(problem, tol=1e-9).sensitivity()
    both = sensitivity.forward(lower=[0.0, 1.0], upper=[0.0, 1.0])
    np.testing.assert_allclose(both.gap, [0.5, 1.0])
    wider = sensitivity.forward(upper=[0.0, 1.0], q=[0.0, -9.0])
    np.testing.assert_allclose(wider.gap, [0.5, 1.0])
    with pytest.raises(ValueError, match=r"unknown 1 .*through each other"):
        sensitivity.forward(lower=[0.0, 1.0])


@st.composite
def biactive_problems(draw):
    """Problems with a known solution: nodes held by either bound, free ones, and ones that touch without a force."""
    size = draw(st.integers(2, 8))
    rng = np.random.default_rng(draw(st.integers(0, 10_000)))
    where = np.array(draw(st.lists(st.sampled_from("luLUf"), min_size=size, max_size=size)))
    where[draw(st.integers(0, size - 1))] = "L"
    symmetric = draw(st.booleans())
    beside = -rng.uniform(0, 1, (size, size)) * (rng.uniform(size=(size, size)) < 0.5)
    if symmetric:
        beside = np.triu(beside, 1) + np.triu(beside, 1).T
    np.fill_diagonal(beside, 0.0)
    matrix = beside + np.diag(0.3 - beside.sum(axis=1))
    lower, upper = -rng.uniform(0.5, 1.5, size), rng.uniform(0.5, 1.5, size)
    upper[(where == "L") & (rng.uniform(size=size) < 0.5)] = np.inf
    gap = np.select([np.isin(where, ["l", "L"]), np.isin(where, ["u", "U"])], [lower, upper], 0.1)
    reaction = np.select([where == "l", where == "u"], [1.0, -1.0], 0.0)
    kind = cq.ContactQP if symmetric else cq.ContactLCP
    return kind(matrix, reaction - matrix @ gap, lower, upper), where, rng


@given(biactive_problems())
def test_no_derivative_leaves_the_bounds(drawn):
    problem, where, rng = drawn
    sensitivity = cq.solve(problem, "active-set", tol=1e-9, on_failure="ignore").sensitivity()
    assert sensitivity.biactive.tolist() == np.flatnonzero(np.isin(where, ["L", "U"])).tolist()
    direction = {name: rng.normal(size=problem.size) for name in ("q", "lower", "upper")}
    found = sensitivity.forward(**direction)
    admissible_to_first_order(sensitivity, found, direction["lower"], direction["upper"])
    moved = problem.with_data(
        problem.q + 1e-6 * direction["q"],
        problem.lower + 1e-6 * direction["lower"],
        problem.upper + 1e-6 * direction["upper"],
    )
    after = cq.solve(moved, "active-set", tol=1e-12, on_failure="ignore")
    np.testing.assert_allclose(found.gap, (after.gap - sensitivity.solution.gap) / 1e-6, atol=1e-6)


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


def test_a_right_contact_set_takes_no_active_sets(monkeypatch):
    """What is left of the answer's error is taken away by the linear solve that derivatives need anyway."""
    from contactqp.solving import sensitivity as module

    solution = cq.solve(membrane(), "psor", tol=1e-5)
    exact = exactly(membrane())
    assert solution.relative_bound > 1e-8
    assert (solution.contact == exact.contact).all()
    monkeypatch.setattr(module, "get_backend", lambda name: pytest.fail("active sets were called"))
    settled: Any = solution.sensitivity().solution
    assert settled.relative_bound < 1e-12
    assert settled.note.endswith("the equations of its free nodes solved")
    np.testing.assert_allclose(settled.gap, exact.gap, atol=1e-13)


def test_arms_that_defeat_multigrid_have_right_derivatives():
    """The nodes are too many for factors, and the arms jump, so that a hierarchy of lattices does not converge."""
    lattice = cq.Frame.rectangle(1, 1).lattice(1 / 71)
    tension = np.exp(2 * np.random.default_rng(0).normal(size=lattice.size))
    given = {"support": 0.02, "load": 1.0}
    solution = cq.solve(cq.Membrane(lattice, tension, **given), "active-set", tol=1e-9, on_failure="ignore")
    sensitivity = solution.sensitivity()
    found, problem, area = sensitivity.forward(load=1.0), solution.problem, lattice.spacing**2
    free = ~solution.contact
    left = (problem.stiffness.matvec(found.gap) + area)[free]
    assert np.abs(left).max() < 1e-9 * area


@pytest.mark.slow
def test_large_lattices_are_differentiated_by_multigrid():
    solution = cq.solve(cq.gallery.bowl(127), tol=1e-9)
    sensitivity = solution.sensitivity()
    weights = np.random.default_rng(0).normal(size=solution.problem.size)
    load = np.ones(solution.problem.size)
    change = sensitivity.forward(load=load)
    assert sensitivity.adjoint(gap=weights)["load"] @ load == pytest.approx(weights @ change.gap, rel=1e-8)
