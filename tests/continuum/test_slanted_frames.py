"""Membranes in frames with sides along diagonals of squares: against finer lattices, and what is refused."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.continuum.relatives import coarser, finer, place_in
from contactqp.profiles import Cone, Hemisphere, HillAndFloor, Paraboloid, Plane, Uppermost

HEXAGON = [(32, 0), (8, 24), (-8, 24), (-32, 0), (-8, -24), (8, -24)]
DIAMOND = [(32, 0), (0, 32), (-32, 0), (0, -32)]
PENTAGON = [(-32, -24), (32, -24), (32, 0), (8, 24), (-32, 24)]

TURNED = [(-32, -32), (0, -64), (32, -32), (16, -16), (0, -32), (-16, -16)]  # its inner corner is one of 270°
NOTCH = [(-32, -32), (32, -32), (32, 32), (16, 32), (0, 16), (-16, 32), (-32, 32)]
FILLET = [(-32, -32), (32, -32), (32, 0), (16, 0), (0, 16), (0, 32), (-32, 32)]  # of 225°, twice
SLIT = [(-32, -32), (32, -32), (32, 32), (24, 32), (0, 8), (0, 32), (-32, 32)]  # of 315°
CUT = [(-32, -32), (32, -32), (32, -8), (24, 0), (0, 0), (0, 32), (-24, 32), (-32, 24)]  # of 270° along lines
SQUARE, HOLE = [(-32, -32), (32, -32), (32, 32), (-32, 32)], [(16, 0), (0, 16), (-16, 0), (0, -16)]
PARTS = [(-32, -32), (-8, -32), (0, -24), (0, -8), (-32, -8)], [(8, 8), (32, 8), (32, 32), (16, 32), (8, 24)]
INWARD = {
    "turned": cq.Frame.polygon(TURNED),
    "notch": cq.Frame.polygon(NOTCH),
    "fillet": cq.Frame.polygon(FILLET),
    "slit": cq.Frame.polygon(SLIT),
    "cut": cq.Frame.polygon(CUT),
    "hole": cq.Frame.polygon(SQUARE, [HOLE]),
    "parts": cq.Frame.polygon(PARTS[0]) | cq.Frame.polygon(PARTS[1]),
}


def membrane(corners, spacing, support=1.25, **changes):
    frame = corners if isinstance(corners, cq.Frame) else cq.Frame.polygon(corners)
    lattice = frame.lattice(spacing)
    return cq.Membrane(lattice, **({"tension": 1.0, "load": 0.03, "support": support} | changes))


def enclosed(model):
    return cq.solve(model, tol=1e-9).continuum("pointwise")


def finer_values(fine, coarse, values):
    """Return values at the nodes of a finer lattice at those of a coarser one."""
    at = place_in(fine, coarse)
    finer = round(coarse.spacing / fine.spacing)
    row, column = np.nonzero(coarse.mask)
    grid = fine.numbering.to_grid(values, ring=1, fill=np.nan)
    found = grid[at[0] + finer * row, at[1] + finer * column]
    assert np.isfinite(found).all()
    return found


def assert_overlap(coarse, fine):
    """Both enclose one membrane, so that their bounds never pass each other."""
    lower, upper = (finer_values(fine.model.lattice, coarse.model.lattice, end) for end in (fine.lower, fine.upper))
    assert (coarse.lower <= upper).all()
    assert (lower <= coarse.upper).all()
    for name in ("area", "reaction"):
        one, two = getattr(coarse.contact, name), getattr(fine.contact, name)
        assert one.lower <= two.upper
        assert two.lower <= one.upper
    assert coarse.largest_depth.lower <= fine.largest_depth.upper
    assert fine.largest_depth.lower <= coarse.largest_depth.upper


SUPPORTS = {
    "floor": 1.25,
    "plane": Plane(1.5, 0.005, -0.003),
    "paraboloid": Paraboloid(1.25, -2000.0),
    "smooth": cq.Smooth(lambda x, y: 1.3 + 0.05 * np.cos(x / 7) * np.sin(y / 5), second_derivative=0.004),
    "kinks": HillAndFloor(),
}


@pytest.mark.parametrize("corners", [HEXAGON, DIAMOND, PENTAGON], ids=["hexagon", "diamond", "pentagon"])
@pytest.mark.parametrize("name", sorted(SUPPORTS))
def test_finer_lattices_enclose_the_same_membrane(corners, name):
    coarse, fine = (enclosed(membrane(corners, spacing, SUPPORTS[name])) for spacing in (4.0, 0.5))
    assert coarse.proven
    assert_overlap(coarse, fine)
    assert fine.error_bound < 0.6 * coarse.error_bound


@pytest.mark.parametrize("frame", INWARD.values(), ids=INWARD)
@pytest.mark.parametrize("name", sorted(SUPPORTS))
def test_corners_that_point_inwards_and_several_parts_are_enclosed(frame, name):
    coarse, fine = (enclosed(membrane(frame, spacing, SUPPORTS[name])) for spacing in (2.0, 1.0))
    assert coarse.proven
    assert_overlap(coarse, fine)
    widths = [found.pointwise.upper - found.pointwise.lower for found in (coarse, fine)]
    assert widths[1].mean() < (0.9 if name == "kinks" else 0.65) * widths[0].mean()


@pytest.mark.parametrize("frame", INWARD.values(), ids=INWARD)
def test_bounds_close_as_fast_as_the_corner_lets_them(frame):
    """The membrane falls from the frame as r^α, with α = 4/5 at 225°, 2/3 at 270° and 4/7 at 315°."""
    found = [membrane(frame, spacing) for spacing in (2.0, 1.0, 0.5)]
    widths = []
    for model in found:
        solution = cq.solve(model, tol=1e-9)
        bounds = solution.continuum("pointwise")
        widths.append([(bounds.upper - solution.deflection).max(), (solution.deflection - bounds.lower).max()])
        widths[-1].append((bounds.upper - bounds.lower).mean())
    orders = np.log(np.divide(widths[0], widths[2])) / np.log(4)
    assert orders[0] > 0.3
    assert orders[1] > 0.3
    assert orders[2] > 1.3


@pytest.mark.slow
@pytest.mark.parametrize("frame", INWARD.values(), ids=INWARD)
@pytest.mark.parametrize("name", ["floor", "kinks"])
def test_much_finer_lattices_enclose_the_same_corners(frame, name):
    found = [enclosed(membrane(frame, spacing, SUPPORTS[name])) for spacing in (4.0, 2.0, 1.0, 0.5, 0.25)]
    for k, coarse in enumerate(found):
        for fine in found[k + 1 :]:
            assert_overlap(coarse, fine)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_crosses_of_any_sides_under_smooth_loads(seed):
    """Corners of a rectangle are cut out, along lines or slanted, so that all kinds of corners come of it."""
    rng = np.random.default_rng(100 + seed)
    width, height = 8.0 * rng.integers(3, 5, 2)
    corners = []
    for quarter, (x, y) in enumerate([(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]):
        right, up = (1, -1)[quarter in (1, 2)], (1, -1)[quarter > 1]
        depth, kind = 4.0, rng.integers(3)
        first, last = (x, y + 2 * depth * up), (x + 2 * depth * right, y)
        if kind == 0:
            cut = [(x, y + depth * up), (x + depth * right, y)]
        elif kind == 1:
            cut = [first, (x + 2 * depth * right, y + 2 * depth * up), last]
        else:
            cut = [first, (x + depth * right, y + 2 * depth * up), (x + 2 * depth * right, y + depth * up), last]
        corners += cut if quarter % 2 == 0 else cut[::-1]
    wave = rng.uniform(0.05, 0.5, 2)
    load = cq.Smooth(
        lambda x, y: 0.3 + 0.2 * np.sin(wave[0] * x) * np.cos(wave[1] * y), second_derivative=0.2 * wave.sum() ** 2
    )
    frame, floor = Plane(0.0, *rng.uniform(-0.02, 0.02, 2)), 2.0 + rng.uniform()
    coarse, fine = (
        enclosed(membrane(corners, spacing, floor, load=load, frame_height=frame)) for spacing in (1.0, 0.25)
    )
    assert_overlap(coarse, fine)
    widths = [found.pointwise.upper - found.pointwise.lower for found in (coarse, fine)]
    assert widths[1].mean() < 0.5 * widths[0].mean()


def test_bounds_over_weak_supports_do_not_run_away():
    """Where the floor hardly presses, an upper bound that is raised at its edge could leave it ever farther."""
    solution = cq.solve(membrane(INWARD["parts"], 0.5, HillAndFloor()), tol=1e-9)
    assert (solution.deflection - solution.continuum("pointwise").lower).max() < 0.5


@pytest.mark.parametrize("corners", [HEXAGON, DIAMOND, PENTAGON], ids=["hexagon", "diamond", "pentagon"])
def test_bounds_are_a_few_times_the_true_error(corners):
    """The truth is taken from a lattice of an eighth of the spacing, within its own bounds."""
    finest = membrane(corners, 0.25)
    exact = cq.solve(finest, tol=1e-9).deflection
    widths = []
    for spacing in (2.0, 1.0):
        model = membrane(corners, spacing)
        solution = cq.solve(model, tol=1e-9)
        found = solution.continuum("pointwise")
        truth = finer_values(finest.lattice, model.lattice, exact)
        error = np.abs(solution.deflection - truth).max()
        assert (found.lower <= truth + 1e-4).all()
        assert (truth <= found.upper + 1e-4).all()
        # An upper bound of the gap is a lower one of the depth.
        assert (solution.deflection - found.lower).max() <= 16 * error
        assert (found.upper - solution.deflection).max() <= 40 * error
        widths.append((found.upper - found.lower).max())
    assert widths[1] < 0.45 * widths[0]


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(SUPPORTS))
def test_much_finer_lattices_enclose_the_same_hexagon(name):
    found = [enclosed(membrane(HEXAGON, spacing, SUPPORTS[name])) for spacing in (2.0, 1.0, 0.25, 0.125)]
    for k, coarse in enumerate(found):
        for fine in found[k + 1 :]:
            assert_overlap(coarse, fine)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_octagons_of_any_sides_under_smooth_loads(seed):
    """Corners of a rectangle are cut off, some of them or all."""
    rng = np.random.default_rng(seed)
    width, height = 4.0 * rng.integers(2, 6, 2)
    cut = [4.0 * rng.integers(0, 1 + int(min(width, height)) // 8) for _ in range(4)]
    corners = [(cut[0], 0), (width - cut[1], 0), (width, cut[1]), (width, height - cut[2]), (width - cut[2], height)]
    corners += [(cut[3], height), (0, height - cut[3]), (0, cut[0])]
    corners = [corner for k, corner in enumerate(corners) if corner != corners[k - 1]]
    wave = rng.uniform(0.05, 0.5, 2)
    load = cq.Smooth(
        lambda x, y: 0.3 + 0.2 * np.sin(wave[0] * x) * np.cos(wave[1] * y), second_derivative=0.2 * wave.sum() ** 2
    )
    frame, floor = Plane(0.0, *rng.uniform(-0.02, 0.02, 2)), 1.0 + rng.uniform()
    coarse, fine = (
        enclosed(membrane(corners, spacing, floor, load=load, frame_height=frame)) for spacing in (1.0, 0.125)
    )
    assert_overlap(coarse, fine)


def test_turned_over_and_mirrored_it_is_the_same():
    down = enclosed(membrane(PENTAGON, 4.0))
    up = enclosed(membrane(PENTAGON, 4.0, -1.25, upwards=True))
    np.testing.assert_allclose(up.lower, -down.upper, atol=1e-9)
    mirrored = enclosed(membrane([(-x, y) for x, y in PENTAGON], 4.0))
    grids = [found.pointwise.lattice.scatter(found.upper) for found in (down, mirrored)]
    np.testing.assert_allclose(grids[0], grids[1][:, ::-1], atol=1e-6)


def test_arrays_are_meant_as_linear_on_halves():
    """A plane given by its values at nodes and frame points is the plane, beyond the frame as well."""
    model = membrane(HEXAGON, 4.0, Plane(1.5, 0.005, -0.003))
    lattice = model.lattice
    row, column = np.indices((lattice.shape[0], lattice.shape[1]))
    x, y = lattice.ring_coordinates(row + 1, column + 1)
    plane = 1.5 + 0.005 * x - 0.003 * y
    by_function, by_values = enclosed(model), enclosed(membrane(HEXAGON, 4.0, plane))
    assert by_values.proven
    assert (by_values.lower <= by_function.upper).all()
    assert (by_function.lower <= by_values.upper).all()
    assert by_values.error_bound < 3 * by_function.error_bound


def test_areas_count_halves():
    found = enclosed(membrane(DIAMOND, 4.0, 100.0))  # out of reach
    assert found.contact.area == (0.0, 0.0)
    assert found.contact.clear.sum() == 2048 / 16 + found.pointwise.halves.squares.sum() / 2
    assert found.pointwise.part_undecided == 0.0
    heavy = enclosed(membrane(DIAMOND, 4.0, 0.01))
    undecided = heavy.contact.undecided
    halves = heavy.pointwise.halves.squares
    area = 16.0 * (undecided[~halves].sum() + undecided[halves].sum() / 2)
    assert heavy.pointwise.part_undecided == pytest.approx(area / 2048.0)
    assert heavy.contact.area.upper <= 2048.0 * (1 + 1e-12)


def test_the_papers_hexagon_is_enclosed_by_its_own_nodes():
    solution = cq.solve(cq.gallery.paper_hexagon(), tol=1e-9)
    found = solution.continuum("pointwise")
    assert found.error_bound < 0.25
    assert found.contact.area.lower > 0
    assert found.energy == solution.continuum().energy
    assert 0 < found.energy.upper - found.energy.lower < 0.03 * abs(found.energy.upper)
    assert "potential energy" in str(found)
    assert "error at nodes" in str(found)
    assert "energy_error <= " in repr(found)
    figure = found.plot()
    assert "all is decided but for" in figure.axes[0].get_title()
    assert "hatched" in solution.plot(continuum="pointwise").axes[0].get_title()


def test_solve_to_halves_the_spacing_of_a_hexagon():
    found = cq.solve_to(lambda spacing: membrane(HEXAGON, spacing), continuum_tol=0.05, spacing=4.0)
    assert found.reached
    assert 0 < found.to_frame()["undecided"].iloc[-1] < 0.5


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: membrane([(0, 0), (8, 0), (8, 4), (0, 8)], 1.0), "and only a frame that runs along lines"),
        (lambda: membrane([(0, 0), (8, 0), (0, 8)], 1.0), "cut squares, .* with corners of 90° and more"),
        (
            lambda: membrane(
                HEXAGON, 4.0, cq.Smooth(lambda x, y: 1e-9 + 0 * x, second_derivative=1.0), frame_height=Plane(0.0)
            ),
            "leave room for the frame",
        ),
        (lambda: membrane(HEXAGON, 4.0, ceiling=-1.0), "not one with a ceiling; effort='energy' does$"),
    ],
)
def test_what_is_not_covered_is_refused_in_words(make, words):
    with pytest.raises(ValueError, match=words):
        enclosed(make())


@pytest.mark.filterwarnings("ignore:support stands above the frame:contactqp.errors.ContactWarning")
@pytest.mark.parametrize("rise", [1.001, 1.3])
def test_supports_with_kinks_leave_room_for_the_frame_themselves(rise):
    """They are replaced by a spline, which is raised to the frame; this hides nothing from the support's own depth."""
    hill = Uppermost(Plane(1.0), Cone(0.3, 0.5, (0.0, 0.0)))

    def below(most):
        hanging = cq.Smooth(
            lambda x, y: most * np.exp(-((x - 20) ** 2 + (y - 12) ** 2) / 8.0), second_derivative=most / 4.0
        )
        return membrane(HEXAGON, 2.0, hill, frame_height=hanging)

    with pytest.raises(ValueError, match="lies beyond the support"):
        enclosed(below(rise))
    assert enclosed(below(0.5)).proven


def test_files_keep_which_squares_are_halved(tmp_path):
    solution = cq.solve(membrane(PENTAGON, 8.0), tol=1e-9)
    solution.save(tmp_path / "pentagon.nc")
    again = cq.load_solution(tmp_path / "pentagon.nc")
    assert isinstance(again.model, cq.Membrane)
    assert again.model.lattice.halved.sum() == 3
    np.testing.assert_array_equal(again.continuum("pointwise").lower, solution.continuum("pointwise").lower)


@pytest.mark.parametrize(
    "corners",
    [HEXAGON, DIAMOND, PENTAGON, NOTCH, SLIT, INWARD["hole"]],
    ids=["hexagon", "diamond", "pentagon", "notch", "slit", "hole"],
)
def test_relatives_have_the_same_frame(corners):
    models = [membrane(corners, spacing, HillAndFloor()) for spacing in (4.0, 2.0)]
    for made, wanted in ((finer(models[0]), models[1]), (coarser(models[1]), models[0])):
        assert made.lattice.halved.sum() == wanted.lattice.halved.sum()
        np.testing.assert_allclose(made.lattice.node_x, wanted.lattice.node_x, atol=1e-12)
        np.testing.assert_allclose(made.lattice.node_y, wanted.lattice.node_y, atol=1e-12)
        np.testing.assert_allclose(enclosed(made).upper, enclosed(wanted).upper, atol=1e-9)
    assert coarser(membrane([(0, 0), (3, 0), (3, 2), (2, 3), (0, 3)], 1.0)) is None


def test_frames_of_any_height_go_on_along_slanted_sides():
    lattice = membrane(HEXAGON, 4.0).lattice
    given = 0.01 * lattice.x + 0.02 * lattice.y[:, None]
    x, y = lattice.frame_places
    inside = (x >= lattice.x[0]) & (x <= lattice.x[-1]) & (y >= lattice.y[0]) & (y <= lattice.y[-1])
    assert inside.all()
    model = finer(membrane(HEXAGON, 4.0, 3.0, frame_height=given))
    x, y, heights = model.frame_places
    np.testing.assert_allclose(heights, 0.01 * x + 0.02 * y, atol=1e-12)


def test_errors_in_slanted_frames_are_estimated():
    model = membrane(DIAMOND, 2.0)
    solution = cq.solve(model, tol=1e-9)
    estimate = solution.discretisation_estimate("pointwise")
    finest = membrane(DIAMOND, 0.25)
    truth = finer_values(finest.lattice, model.lattice, cq.solve(finest, tol=1e-9).deflection)
    assert 0.5 < estimate.error / np.abs(solution.deflection - truth).max() < 2
    energy = solution.discretisation_estimate("energy")
    assert energy.spacings == (2.0, 4.0, 8.0)
    assert energy.error < solution.continuum().energy_error < 1.3 * energy.error
    assert 0.8 < energy.order < 1.1


def test_a_support_may_end_where_there_is_no_membrane():
    """The hemisphere's rim lies in the missing quarter, where nothing is known of its second derivatives."""
    frame = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    found = enclosed(membrane(frame, 0.25, Hemisphere(0.1, 2.5), tension=1.5, load=1.0))
    assert found.proven
    assert (found.lower <= found.upper).all()
