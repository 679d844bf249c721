"""Membranes whose frame cuts the arms of the lattice: closed forms, orders, and the same model by other ways."""

import numpy as np
import pytest
from scipy.optimize import brentq

import contactqp as cq
from contactqp.io.cases import load_case
from contactqp.proof import lattice_measures
from contactqp.proof.measure import measure


def contact_radius(floor, pressure=1.0, tension=1.0, radius=1.0):
    """p(R² - a²)/4T + (pa²/2T) ln(a/R) = f: at the contact circle deflection and slope are those of the floor."""

    def excess(a):
        return (
            pressure * (radius**2 - a * a) / (4 * tension)
            + pressure * a * a / (2 * tension) * np.log(a / radius)
            - floor
        )

    return brentq(excess, 1e-9, radius)


def on_floor(r, floor):
    a = contact_radius(floor)
    return np.where(r < a, floor, (1 - r * r) / 4 + a * a / 2 * np.log(np.maximum(r, a)))


def disk(nodes, fitted=True, support=0.1, center=(0.013, 0.007), **options):
    lattice = cq.Frame.disk(1.0, center=center).lattice(2 / (nodes + 1), (0.0, 0.0), fitted=fitted)
    return cq.Membrane(lattice, options.pop("tension", 1.0), load=1.0, support=support, **options)


def error_on_disk(nodes, floor, fitted=True):
    membrane = disk(nodes, fitted, floor)
    r = np.hypot(membrane.node_x - 0.013, membrane.node_y - 0.007)
    exact = (1 - r * r) / 4 if floor == np.inf else on_floor(r, floor)
    return float(np.abs(cq.solve(membrane, tol=1e-9).deflection - exact).max())


def order(sizes, errors):
    return -np.polyfit(np.log([size + 1 for size in sizes]), np.log(errors), 1)[0]


@pytest.mark.filterwarnings("ignore:with spacing")
@pytest.mark.parametrize("floor", [0.05, 0.1, 0.15, np.inf])
def test_the_disk_is_of_second_order(floor):
    sizes = [31, 63, 127]
    errors = [error_on_disk(size, floor) for size in sizes]
    assert errors[-1] < 3e-5
    assert errors[-1] < error_on_disk(127, floor, fitted=False) / 50
    assert order(sizes, errors) >= 1.7


@pytest.mark.slow
@pytest.mark.parametrize("floor", [0.05, 0.1, 0.15, np.inf])
def test_the_disk_is_of_second_order_up_to_511(floor):
    sizes = [31, 63, 127, 255, 511]
    assert order(sizes, [error_on_disk(size, floor) for size in sizes]) >= 1.9


def ellipse(nodes, tension=(2.0, 1.0), **options):
    from shapely import Point, affinity

    contour = affinity.scale(Point(0, 0).buffer(1, quad_segs=20_000), 1.3, 0.7)
    lattice = cq.Frame.from_shapely(contour).lattice(2.6 / (nodes + 1), (0.0, 0.0), fitted=True)
    return cq.Membrane(lattice, tension, load=1.0, support=np.inf, **options)


def error_on_ellipse(nodes):
    """p(1 - x²/a² - y²/b²)/(2(T_x/a² + T_y/b²))."""
    membrane = ellipse(nodes)
    shape = 1 - (membrane.node_x / 1.3) ** 2 - (membrane.node_y / 0.7) ** 2
    exact = shape / (2 * (2 / 1.3**2 + 1 / 0.7**2))
    return float(np.abs(cq.solve(membrane, tol=1e-9).deflection - exact).max())


def test_the_ellipse_with_two_tensions_is_of_second_order():
    sizes = [15, 31, 63, 127]
    assert order(sizes, [error_on_ellipse(size) for size in sizes]) >= 1.8


@pytest.mark.slow
def test_the_ellipse_with_two_tensions_is_of_second_order_up_to_511():
    sizes = [31, 63, 127, 255, 511]
    assert order(sizes, [error_on_ellipse(size) for size in sizes]) >= 1.9


def test_one_node_by_hand():
    """Arms of θ = 1/4, 1, 1/2, 1 and tension 2: the node's diagonal is 2 (4 + 1 + 2 + 1) = 16, and w = PΔ²/16."""
    frame = cq.Frame.polygon([(-0.25, -0.5), (1, -0.5), (1, 1), (-0.25, 1)])
    membrane = cq.Membrane(frame.lattice(1.0, (0.0, 0.0), fitted=True), 2.0, load=1.0, support=1.0)
    np.testing.assert_allclose(membrane.problem.G.toarray(), [[16.0]], rtol=1e-11)
    solution = cq.solve(membrane)
    np.testing.assert_allclose(solution.deflection, 1 / 16, rtol=1e-11)
    assert solution.max_slope == pytest.approx(0.25, rel=1e-9)  # 1/16 over the shortest arm


def plain_matrix(membrane, tension=lambda x, y: (1.0, 1.0)):
    """The matrix by loops over nodes and their four arms, and the pull of a frame of height 1 + x."""
    lattice = membrane.lattice
    number = lattice.scatter(np.arange(lattice.size), fill=-1).astype(int)
    matrix, pull = np.zeros((lattice.size, lattice.size)), np.zeros(lattice.size)
    rows, columns = lattice.shape
    for i in range(rows):
        for j in range(columns):
            if number[i, j] < 0:
                continue
            for up, right in ((0, 1), (0, -1), (1, 0), (-1, 0)):
                a, b = i + up, j + right
                beside = number[a, b] if 0 <= a < rows and 0 <= b < columns else -1
                cuts = lattice.cuts.along_x if right else lattice.cuts.along_y
                length = cuts[i + (up > 0), j + (right > 0)]
                x, y = lattice.x[j] + right * lattice.spacing / 2, lattice.y[i] + up * lattice.spacing / 2
                arm = tension(x, y)[0 if right else 1] / (length if beside < 0 else 1.0)
                matrix[number[i, j], number[i, j]] += arm
                if beside >= 0:
                    matrix[number[i, j], beside] -= arm
                else:
                    pull[number[i, j]] += arm * (1 + lattice.x[j] + right * length * lattice.spacing)
    return matrix, pull


@pytest.mark.parametrize("tension", [1.0, (2.0, 0.5), lambda x, y: 2 + x + y])
def test_the_matrix_and_the_pull_of_the_frame_are_those_of_cables(tension):
    frame = (cq.Frame.disk(1.0) - cq.Frame.disk(0.3, center=(0.2, 0.1))) | cq.Frame.rectangle(0.9, 0.9, center=(1.1, 0))
    lattice = frame.lattice(0.13, (0.0, 0.0), fitted=True)
    membrane = cq.Membrane(lattice, tension, load=1.0, support=np.inf, frame_height=lambda x, y: 1 + x)

    def of_arm(x, y):
        if callable(tension):
            return (tension(x, y),) * 2
        return tension if isinstance(tension, tuple) else (tension, tension)

    matrix, pull = plain_matrix(membrane, of_arm)
    np.testing.assert_allclose(membrane.problem.G.toarray(), matrix, rtol=1e-12, atol=1e-12 * matrix.max())
    depths = np.random.default_rng(1).normal(size=lattice.size)
    np.testing.assert_allclose(membrane.pull(depths), matrix @ depths - pull, atol=1e-11 * matrix.max())


@pytest.mark.parametrize("height", [2.0, lambda x, y: 2 + 0.3 * x - 0.2 * y])
def test_a_plane_frame_is_spanned_by_a_plane(height):
    """Without a load the membrane is the frame's plane, to rounding, wherever the contour cuts its arms."""
    lattice = cq.Frame.disk(1.0, center=(0.05, 0.02)).lattice(0.13, (0.0, 0.0), fitted=True)
    membrane = cq.Membrane(lattice, (2.0, 1.0), load=0.0, support=np.inf, frame_height=height)
    expected = height(lattice.node_x, lattice.node_y) if callable(height) else np.full(lattice.size, height)
    np.testing.assert_allclose(cq.solve(membrane, tol=1e-12).deflection, expected, atol=1e-11)
    x, y, heights = membrane.frame_places
    np.testing.assert_allclose(heights, height(x, y) if callable(height) else 2.0)
    assert abs(cq.solve(membrane).force_balance.imbalance) < 1e-12


def test_a_function_of_the_frames_height_is_asked_on_the_contour_alone():
    def height(x, y):
        assert np.abs(np.hypot(x, y) - 1).max() < 1e-9
        return 0.01 * x * y

    disk(15, center=(0.0, 0.0), frame_height=height)


def test_heights_upwards_are_the_same_turned_over():
    down = disk(15, frame_height=lambda x, y: 0.1 * x, support=0.15)
    up = disk(15, frame_height=lambda x, y: -0.1 * x, support=-0.15, upwards=True)
    np.testing.assert_array_equal(cq.solve(up).deflection, -cq.solve(down).deflection)
    np.testing.assert_array_equal(up.frame_places[2], -down.frame_places[2])


def test_another_tension_is_that_of_a_new_model():
    for tension in (1.0, lambda x, y: 2 + x):
        changed = cq.solve(cq.Solver(disk(15, tension=tension)).solve(tension=3.0).model)
        new = disk(15, tension=3.0 if tension == 1.0 else lambda x, y: 3 * (2 + x))
        np.testing.assert_allclose(changed.deflection, cq.solve(new).deflection, atol=1e-12)


def test_a_foundation_and_a_ceiling_go_with_it():
    membrane = disk(31, foundation=3.0, ceiling=-0.01, support=0.05)
    answers = [cq.solve(membrane, backend, tol=1e-10).deflection for backend in ("multigrid", "active-set", "psor")]
    for answer in answers[1:]:
        np.testing.assert_allclose(answer, answers[0], atol=1e-10)
    assert abs(cq.solve(membrane).force_balance.imbalance) < 1e-12


@pytest.mark.filterwarnings("ignore:with spacing")
@pytest.mark.parametrize("center", [(0.0, 0.0), (0.013, 0.007), (0.0171, -0.0003)])
def test_multigrid_takes_two_cycles_more_at_most(center):
    for nodes in (63, 127, 255):
        cycles = [
            cq.solve(disk(nodes, fitted, support, center=center), "multigrid").iterations
            for support in (0.15, np.inf)
            for fitted in (False, True)
        ]
        assert cycles[1] <= cycles[0] + 2
        assert cycles[3] <= cycles[2] + 2


def test_it_is_written_and_read(tmp_path):
    for options in (
        {},
        {"frame_height": lambda x, y: 0.1 * x * y},
        {"tension": (2.0, 1.0)},
        {"tension": lambda x, y: 2 + x},
    ):
        solution = cq.solve(disk(15, **options))
        again = cq.load_solution(solution.save(tmp_path / "disk.nc"))
        np.testing.assert_array_equal(again.model.problem.q, solution.problem.q)
        assert again.problem.stiffness.equals(solution.problem.stiffness)
        assert "fitted to its contour" in repr(again.model)


def test_what_is_told_of_it():
    membrane = disk(15)
    assert membrane.cautions == ()
    assert "frame fitted to its contour" in repr(membrane)


def test_derivatives_by_frame_height_and_tension():
    membrane = disk(15, support=0.1)
    gradient = cq.solve(membrane, tol=1e-12).sensitivity().adjoint(deflection=1.0)
    step = 1e-5
    for name, at in (("tension", 1.0), ("frame_height", 0.0)):
        sums = [
            cq.solve(disk(15, support=0.1, **{name: at + way}), tol=1e-12).deflection.sum() for way in (step, -step)
        ]
        assert gradient[name] == pytest.approx((sums[0] - sums[1]) / (2 * step), rel=1e-4)


def test_a_case_file_has_it(tmp_path):
    case = tmp_path / "disk.toml"
    frame = '{ shape = "disk", radius = 1.0 }'
    text = f"frame = {frame}\nspacing = 0.125\nfitted = true\ntension = 1.0\nload = 1.0\nsupport = 0.2\n"
    case.write_text(text)
    assert load_case(case).lattice.cuts is not None
    case.write_text(text.replace(frame, '{ shape = "mask", file = "mask.npy" }'))
    np.save(tmp_path / "mask.npy", np.ones((3, 3)))
    with pytest.raises(cq.CaseFileError, match="fitted"):
        load_case(case)


@pytest.mark.parametrize("support", [0.1, np.inf])
@pytest.mark.parametrize("ceiling", [None, -0.01])
def test_compiled_passes_of_the_judge_say_what_vectors_say(monkeypatch, support, ceiling):
    membrane = disk(31, support=support, ceiling=ceiling, frame_height=lambda x, y: 0.01 * x)
    problem = membrane.problem
    assert problem.stiffness.rimmed_lattice is not None
    rng = np.random.default_rng(3)
    gaps = [cq.solve(membrane, tol=1e-9).gap, problem.project(rng.normal(size=problem.size))]
    by_vectors = [measure(problem, gap) for gap in gaps]
    certificates = [measures.certificate() for measures in by_vectors]
    monkeypatch.setattr(lattice_measures, "_WORTH_COMPILED_PASSES", 0)
    for gap, other, expected in zip(gaps, by_vectors, certificates, strict=True):
        compiled = measure(problem, gap)
        assert type(compiled) is lattice_measures.LatticeMeasures
        assert type(other) is not type(compiled)
        assert compiled.gap_bound >= other.gap_bound * (1 - 1e-6)  # it does not know what is admissible
        for name, value in vars(other.residuals).items():
            assert getattr(compiled.residuals, name) == pytest.approx(value, rel=1e-9, abs=1e-13)
        certificate = compiled.certificate()
        np.testing.assert_allclose(certificate.lower, expected.lower, atol=1e-12, rtol=1e-6)
        np.testing.assert_allclose(certificate.upper, expected.upper, atol=1e-12, rtol=1e-6)
        np.testing.assert_array_equal(certificate.clear, expected.clear)


def test_its_barrier_is_a_parabola_that_holds_exactly():
    """G v ≥ s in rational arithmetic, with the stiffnesses as they are stored."""
    from fractions import Fraction

    membrane = disk(15)
    problem = membrane.problem
    barrier, matrix = problem.barrier, problem.G.toarray()
    exact = [[Fraction(entry) for entry in row] for row in matrix]
    v = [Fraction(value) for value in barrier.v]
    # An entry of the diagonal is rounded once from arms and spring.
    slack = Fraction(float(np.diag(matrix).max() * barrier.v.max())) * Fraction(1, 2**50)
    for row in exact:
        assert sum(a * b for a, b in zip(row, v, strict=True)) >= Fraction(barrier.least_s) - slack
    assert barrier.kind in ("paraboloid", "strip along x", "strip along y")


def test_derivatives_by_arms_and_by_points_of_the_frame_are_differences():
    def model(tension, height):
        lattice = cq.Frame.disk(1.0, center=(0.03, 0.02)).lattice(0.3, (0.0, 0.0), fitted=True)
        return cq.Membrane(lattice, tension, load=1.0, support=0.12, frame_height=height)

    def height(x, y):
        return 0.01 * x - 0.02 * y

    base = model((1.0, 2.0), height)
    weights = np.random.default_rng(0).normal(size=base.size)
    gradient = cq.solve(base, tol=1e-12).sensitivity().adjoint(deflection=weights)
    step = 1e-6
    for name, direction in (("arms_x", (1.0, 0.0)), ("arms_y", (0.0, 1.0))):
        ends = [
            weights
            @ cq.solve(model(tuple(np.add((1.0, 2.0), np.multiply(direction, way))), height), tol=1e-13).deflection
            for way in (step, -step)
        ]
        assert gradient[name].sum() == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-5)
    ends = [
        weights @ cq.solve(model((1.0, 2.0), lambda x, y, way=way: height(x, y) + way), tol=1e-13).deflection
        for way in (step, -step)
    ]
    assert gradient["frame_heights"].sum() == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-5)
