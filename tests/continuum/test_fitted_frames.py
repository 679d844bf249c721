"""Membranes on lattices that are fitted to their contour: enclosed at every point, against closed forms."""

import itertools

import numpy as np
import pytest
from scipy.optimize import brentq

import contactqp as cq
from contactqp.profiles import Cone, Hemisphere, Paraboloid

DISK = cq.Frame.disk(1.0)


def turned(corners, angle, move=(0.0, 0.0)):
    c, s = np.cos(angle), np.sin(angle)
    return [(c * x - s * y + move[0], s * x + c * y + move[1]) for x, y in corners]


def enclosed(frame, spacing, **changes):
    lattice = frame.lattice(spacing, fitted=True)
    model = cq.Membrane(lattice, **({"tension": 1.0, "load": 1.0, "support": 0.1} | changes))
    return cq.solve(model, tol=1e-10).continuum("pointwise")


def places(found):
    return found.model.node_x, found.model.node_y


def assert_holds(found, exact, error=1e-13):
    """A deflection is within its bounds at the nodes, and its gap in the squares, at many places of the region."""
    value = exact(*places(found))
    assert (found.lower <= value + error).all()
    assert (value <= found.upper + error).all()
    bounds = found.pointwise
    (x, y), outline = bounds.edges, bounds.lattice.outline
    rng = np.random.default_rng(0)
    across, up = (rng.uniform(line[0], line[-1], 20_000) for line in (x, y))
    inside = outline.holds(across, up)
    across, up = across[inside], up[inside]
    column, row = np.searchsorted(x, across) - 1, np.searchsorted(y, up) - 1
    given = found.model.given["support"]
    support = given(across, up) if callable(given) else given
    gap = support - exact(across, up)
    assert (bounds.gap_lower_in_cells[row, column] <= gap + error).all()
    assert (gap <= bounds.gap_upper_in_cells[row, column] + error).all()
    assert not (found.contact.contact[row, column] & (gap > 1e-9)).any()
    assert not (found.contact.clear[row, column] & (gap <= 0)).any()


def on_floor(depth, radius=1.0, load=1.0):
    """Return the deflection over a floor on a disk, T = 1, and the radius of contact."""

    def height(r, a):
        return depth - load * (r**2 - a**2) / 4 + load * a**2 / 2 * np.log(r / a)

    a = brentq(lambda a: height(radius, a), 1e-6, radius * (1 - 1e-9), xtol=1e-15)
    return lambda x, y: np.where(np.hypot(x, y) > a, height(np.maximum(np.hypot(x, y), a), a), depth), a


def test_a_free_disk():
    def exact(x, y):
        return (1 - x**2 - y**2) / 4

    widths = []
    for spacing in (1 / 8, 1 / 16, 1 / 32):
        found = enclosed(DISK, spacing, support=0.5)
        assert found.proven
        assert_holds(found, exact)
        assert found.largest_depth.lower <= 0.25 <= found.largest_depth.upper
        widths.append((found.upper - found.lower).max())
    assert widths[2] < 0.3 * widths[1] < 0.09 * widths[0]
    assert widths[2] < 0.4 / 32**2


@pytest.mark.parametrize("center", [(0.0, 0.0), (0.013, -0.41)])
def test_a_disk_over_a_floor(center):
    """Its contact, reaction and depth are known, too; the frame may lie anywhere on the lattice."""
    own, a = on_floor(0.1)

    def exact(x, y):
        return own(x - center[0], y - center[1])

    widths = []
    for spacing in (1 / 16, 1 / 32):
        found = enclosed(cq.Frame.disk(1.0, center), spacing)
        assert_holds(found, exact)
        contact = found.contact
        assert contact.area.lower <= np.pi * a**2 <= contact.area.upper
        assert contact.reaction.lower <= np.pi * a**2 <= contact.reaction.upper
        assert found.largest_depth.lower <= 0.1 <= found.largest_depth.upper
        assert contact.free_boundary_width < 6 * spacing
        widths.append((found.upper - found.lower).max())
    assert widths[1] < 0.45 * widths[0]
    assert widths[1] < 3 / 32**2
    assert contact.area.upper - contact.area.lower < 1.0


def test_a_ring_over_a_floor():
    """Contact is a ring; each part of the membrane is held at one of the circles."""
    depth, inner = 0.02, 0.4

    def height(r, a):
        return depth - (r**2 - a**2) / 4 + a**2 / 2 * np.log(r / a)

    outer_edge = brentq(lambda a: height(1.0, a), 0.6, 0.99, xtol=1e-15)
    inner_edge = brentq(lambda a: height(inner, a), inner * 1.01, 0.65, xtol=1e-15)

    def exact(x, y):
        r = np.clip(np.hypot(x, y), inner, 1.0)
        return np.where(
            r > outer_edge,
            height(np.maximum(r, outer_edge), outer_edge),
            np.where(r < inner_edge, height(np.minimum(r, inner_edge), inner_edge), depth),
        )

    found = enclosed(DISK - cq.Frame.disk(inner), 1 / 32, support=depth)
    assert_holds(found, exact)
    area = np.pi * (outer_edge**2 - inner_edge**2)
    assert found.contact.area.lower <= area <= found.contact.area.upper
    assert found.contact.reaction.lower <= area <= found.contact.reaction.upper
    assert (found.upper - found.lower).max() < 3 / 32**2


def test_torsion_of_a_round_bar():
    """An elastic-plastic bar (Prandtl 1903): |∇w| ≤ 1, so that w stays below the distance to the boundary."""

    def exact(x, y):
        r = np.hypot(x, y)
        return np.where(r >= 0.5, 1 - r, 0.75 - r**2)

    for spacing in (1 / 8, 1 / 16):
        found = enclosed(DISK, spacing, load=4.0, support=Cone(1.0, -1.0))
        assert found.proven
        assert_holds(found, exact, error=1e-12)


@pytest.mark.parametrize("spacing", [1 / 8, 1 / 20])
def test_an_equilateral_triangle(spacing):
    """Its stress function is a product of the distances to the sides (Saint-Venant 1855)."""
    height = np.sqrt(3.0) / 2
    corners = [(-0.5, 0.0), (0.5, 0.0), (0.0, height)]

    def plain(x, y):
        left = (height * (0.5 + x) - y * 0.5, height * (0.5 - x) - y * 0.5)
        return y * left[0] * left[1] / height

    # -Δ(y d₁ d₂) of the three distances is constant: found by the closed form at one place, once and for all.
    step = 1e-3
    bend = sum(plain(dx, 0.3 + dy) for dx, dy in ((step, 0), (-step, 0), (0, step), (0, -step))) - 4 * plain(0, 0.3)
    factor = -(step**2) / bend
    found = enclosed(cq.Frame.polygon(turned(corners, 0.2)), spacing, support=1.0)
    c, s = np.cos(0.2), np.sin(0.2)
    assert_holds(found, lambda x, y: factor * plain(c * x + s * y, -s * x + c * y), error=1e-9)


@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 4])
def test_a_turned_rectangle(angle):
    """A free membrane on a rectangle is a series of sines; at its corners second derivatives have no limit."""
    wide, high = 1.6, 1.0
    odd = np.arange(1, 400, 2)

    def plain(x, y):
        # w = y(b - y)/2 less what vanishes it at the ends x = ± a/2.
        terms = [
            4 * high**2 / (np.pi * k) ** 3 * np.sin(k * np.pi * y / high)
            * np.exp(k * np.pi / high * (np.abs(x) - wide / 2))
            * (1 + np.exp(-2 * k * np.pi / high * np.abs(x))) / (1 + np.exp(-k * np.pi * wide / high))
            for k in odd
        ]  # fmt: skip
        return y * (high - y) / 2 - sum(terms)

    c, s = np.cos(angle), np.sin(angle)

    def exact(x, y):
        return plain(c * x + s * y, -s * x + c * y + high / 2)

    corners = [(-wide / 2, -high / 2), (wide / 2, -high / 2), (wide / 2, high / 2), (-wide / 2, high / 2)]
    widths = []
    for spacing in (1 / 16, 1 / 32):
        found = enclosed(cq.Frame.polygon(turned(corners, angle)), spacing, support=1.0)
        assert_holds(found, exact, error=1e-7)
        widths.append((found.upper - found.lower).max())
    assert widths[1] < 0.4 * widths[0]


def harmonic(kind):
    """Return a polynomial of which -Δ is one, and a bound of its second derivatives about (0, 0)."""
    found = {
        "quadratic": (lambda x, y: -(x**2) / 3 - y**2 / 6 + 0.1 * x, 0.7),
        "cubic": (lambda x, y: -(x**2 + y**2) / 4 + 0.1 * (x**3 - 3 * x * y**2), 0.5 + 0.6 * 2.0),
        "quartic": (lambda x, y: -(x**2 + y**2) / 4 + 0.05 * (x**4 - 6 * x**2 * y**2 + y**4), 0.5 + 0.6 * 4.0),
    }
    return found[kind]


@pytest.mark.parametrize(("seed", "kind"), [*itertools.product(range(6), ["quadratic", "cubic", "quartic"])])
def test_polynomials_on_any_polygon(seed, kind):
    """Convex or not, with corners of any angle: the frame's height is the polynomial itself."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 9))
    angles = (np.arange(count) + rng.uniform(-0.3, 0.3, count)) * (2 * np.pi / count)
    radius = rng.uniform(0.5, 1.3, count) if seed % 2 else np.ones(count)
    frame = cq.Frame.polygon([(r * np.cos(a), r * np.sin(a)) for r, a in zip(radius, angles, strict=True)])
    exact, bend = harmonic(kind)
    found = enclosed(frame, 0.07, support=9.0, frame_height=cq.Smooth(exact, second_derivative=bend))
    assert found.proven
    assert_holds(found, exact, error=1e-11)
    assert np.isfinite(found.error_bound)


@pytest.mark.parametrize(
    "support",
    [
        0.08,
        Paraboloid(0.05, 5.0, center=(-0.4, -0.3)),
        Hemisphere(0.1, 3.0, center=(-0.4, -0.3)),
        Cone(0.02, 0.1, center=(-0.4, -0.3)),
        cq.Smooth(lambda x, y: 0.08 + 0.03 * np.cos(2 * x + y), second_derivative=0.15),
    ],
    ids=["floor", "paraboloid", "hemisphere", "cone", "waves"],
)
@pytest.mark.parametrize(
    "frame",
    [cq.Frame.hexagon(1.0), cq.Frame.polygon(turned([(-1, -1), (1, -1), (1, 0), (0, 0), (0, 1), (-1, 1)], 0.3))],
    ids=["hexagon", "L"],
)
def test_finer_lattices_enclose_the_same_membrane(frame, support):
    load = cq.Smooth(lambda x, y: 1 + 0.5 * np.sin(3 * x), second_derivative=4.5)
    height = cq.Smooth(lambda x, y: 0.02 * x * y, second_derivative=0.02)
    coarse, fine = (
        enclosed(frame, spacing, load=load, support=support, frame_height=height) for spacing in (1 / 12, 1 / 24)
    )
    assert coarse.proven
    own, other = (
        {(round(x * 24), round(y * 24)): k for k, (x, y) in enumerate(zip(*places(f), strict=True))}
        for f in (coarse, fine)
    )
    pairs = np.array([(own[place], other[place]) for place in own if place in other])
    assert len(pairs) > 100
    one, two = pairs.T
    assert (coarse.lower[one] <= fine.upper[two]).all()
    assert (fine.lower[two] <= coarse.upper[one]).all()
    for name in ("area", "reaction"):
        low, high = zip(*(getattr(found.contact, name) for found in (coarse, fine)), strict=True)
        assert max(low) <= min(high)
    assert (fine.upper - fine.lower).mean() < 0.6 * (coarse.upper - coarse.lower).mean()


@pytest.mark.slow
@pytest.mark.parametrize("corners", [5, 6, 8])
def test_corners_do_not_spoil_the_order(corners):
    """Where second derivatives have no bound, functions about corners take them."""
    angles = np.arange(corners) * 2 * np.pi / corners
    frame = cq.Frame.polygon(turned(np.column_stack([np.cos(angles), np.sin(angles)]).tolist(), 0.1))
    widths = [enclosed(frame, spacing) for spacing in (1 / 32, 1 / 64, 1 / 128)]
    widths = [(found.upper - found.lower).max() for found in widths]
    assert widths[2] < 0.4 * widths[1] < 0.16 * widths[0]
    assert widths[2] < 4 / 128**2


@pytest.mark.slow
def test_corners_that_point_inwards_do_not_spoil_it_either():
    """What is known of the membrane is of second order; the lattice's own answer is not."""
    frame = cq.Frame.polygon(turned([(-1, -1), (1, -1), (1, 0), (0, 0), (0, 1), (-1, 1)], 0.3))
    widths = [(found.upper - found.lower).mean() for found in (enclosed(frame, h) for h in (1 / 32, 1 / 64, 1 / 128))]
    assert widths[2] < 0.55 * widths[1] < 0.3 * widths[0]


def test_a_tip_next_to_a_corner_that_points_inwards():
    """What is known of the membrane at the corner is of no use there; the bounds are wide, and hold."""
    frame = cq.Frame.polygon(turned([(-1, -1), (1, -1), (1, 0), (0, 0), (0, 1), (-1, 1)], 0.3))
    found = [enclosed(frame, spacing, support=Cone(0.02, 0.1)) for spacing in (1 / 12, 1 / 24, 1 / 48)]
    for one in found:
        assert (one.upper - one.lower).max() <= 0.25


def test_turned_over_it_is_the_same():
    frame = cq.Frame.hexagon(1.0)
    down = enclosed(frame, 1 / 12)
    up = enclosed(frame, 1 / 12, support=-0.1, upwards=True)
    np.testing.assert_allclose(up.lower, -down.upper, atol=1e-9)
    np.testing.assert_allclose(up.upper, -down.lower, atol=1e-9)


def test_units_and_places_do_not_matter():
    """A frame a million lengths away, and one in units a million times as small."""
    plain = enclosed(cq.Frame.hexagon(1.0), 1 / 16)
    far = enclosed(cq.Frame.hexagon(1.0, center=(5e5, 4e6)), 1 / 16)
    assert far.error_bound == pytest.approx(plain.error_bound, rel=0.2)
    small = enclosed(cq.Frame.hexagon(1e-6), 1e-6 / 16, support=1e-7, load=1e6)
    assert small.error_bound == pytest.approx(1e-6 * plain.error_bound, rel=0.1)


def test_arrays_are_meant_as_their_interpolants():
    lattice = DISK.lattice(1 / 12, fitted=True)
    depth = 0.1 + 0.01 * lattice.node_x
    model = cq.Membrane(lattice, tension=1.0, load=np.ones(lattice.size), support=depth)
    found = cq.solve(model, tol=1e-10).continuum("pointwise")
    assert found.proven
    fine = enclosed(DISK, 1 / 24, support=cq.Smooth(lambda x, y: 0.1 + 0.01 * x, second_derivative=0.0))
    own = {(round(x * 24), round(y * 24)): k for k, (x, y) in enumerate(zip(*places(fine), strict=True))}
    other = [own[round(x * 24), round(y * 24)] for x, y in zip(*places(found), strict=True)]
    assert (found.lower <= fine.upper[other] + 1e-4).all()  # beyond the nodes an array goes on as it will
    assert (fine.lower[other] <= found.upper + 1e-4).all()


def test_functions_without_constants_are_sampled():
    found = enclosed(DISK, 1 / 12, support=lambda x, y: 0.1 + 0.01 * x**2, frame_height=lambda x, y: 0.001 * x)
    assert not found.proven
    assert found.sampled == ("support", "frame_height")
    assert np.isfinite(found.error_bound)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: enclosed(DISK, 1 / 8, tension=(1.0, 2.0)), r"one tension over one support, not one with a tension"),
        (lambda: enclosed(DISK, 1 / 8, foundation=1.0), r"not one with an elastic foundation$"),
    ],
)
def test_what_is_not_covered_is_refused_in_words(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_supports_above_the_frame_are_refused():
    step = cq.Smooth(lambda x, y: 0.3 * (x > 0.3), lipschitz=9.0)
    lattice = DISK.lattice(1 / 8, fitted=True)
    with pytest.warns(cq.ContactWarning, match="support stands above the frame"):
        solution = cq.solve(cq.Membrane(lattice, tension=1.0, load=1.0, support=0.1, frame_height=step), tol=1e-10)
    with pytest.raises(ValueError, match="lies beyond the support"):
        solution.continuum("pointwise")


def test_energies_are_refused_and_the_pointwise_bounds_named():
    solution = cq.solve(cq.Membrane(DISK.lattice(1 / 8, fitted=True), tension=1.0, load=1.0, support=0.1))
    with pytest.raises(ValueError, match=r"cuts squares anywhere.*effort='pointwise'"):
        solution.continuum("energy")
    with pytest.raises(ValueError, match=r"made by Frame\.lattice"):
        solution.discretisation_estimate()


def test_files_keep_the_contour(tmp_path):
    for frame in (DISK - cq.Frame.disk(0.4), cq.Frame.hexagon(1.0)):
        model = cq.Membrane(frame.lattice(1 / 10, fitted=True), tension=1.0, load=1.0, support=0.02)
        solution = cq.solve(model, tol=1e-10)
        solution.save(tmp_path / "fitted.nc")
        again = cq.load_solution(tmp_path / "fitted.nc")
        np.testing.assert_array_equal(again.continuum("pointwise").lower, solution.continuum("pointwise").lower)


def test_a_lattice_is_chosen_for_the_answer():
    def model(spacing):
        return cq.Membrane(DISK.lattice(spacing, fitted=True), tension=1.0, load=1.0, support=0.1)

    found = cq.solve_to(model, continuum_tol=0.02, spacing=1 / 8)
    assert found.reached
    assert found.spacing == 1 / 32


def test_maps_end_at_the_contour():
    figure = enclosed(DISK - cq.Frame.disk(0.4), 1 / 12, support=0.02).plot()
    (axes,) = figure.axes
    assert any(artist.get_clip_path() is not None for artist in axes.collections)
    assert "membrane itself" in axes.get_title()
