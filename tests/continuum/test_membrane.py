"""What `continuum("pointwise")` says of models: closed forms, supports of many kinds, and what is refused."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.continuum.data import Data
from contactqp.continuum.posed import posed_of
from contactqp.profiles import Hemisphere, Paraboloid, Plane


def square(squares, support=0.03, side=1.0, **changes):
    lattice = cq.Frame.rectangle(side, side).lattice(side / squares)
    return cq.Membrane(lattice, **({"tension": 1.0, "load": 1.0, "support": support} | changes))


def enclosed(model):
    return cq.solve(model, tol=1e-9).continuum("pointwise")


def assert_holds(found, exact, room=1e-12):
    assert (found.lower <= exact + room).all()
    assert (exact - room <= found.upper).all()


@pytest.mark.parametrize("name", ["ball", "ring", "constant-obstacle"])
def test_closed_forms_are_enclosed(name):
    known = cq.gallery.load(name, n=31)
    found = enclosed(known.model)
    assert found.proven
    assert_holds(found, known.deflection)
    assert found.contact.area.lower <= known.contact_area <= found.contact.area.upper


def test_a_ball_with_a_proof():
    """Bueler's ball as a profile that tells its curvature, in a frame that does as well, is proven and enclosed."""
    lattice = cq.Frame.rectangle(1.2, 1.2).lattice(1.2 / 24)
    ball = Hemisphere(depth=-1.0, radius=1.0)

    def beyond(x, y):
        r = np.maximum(np.hypot(x, y), 0.3)
        height = np.sqrt(1 - 0.3**2)
        return np.where(np.hypot(x, y) <= 0.3, ball(x, y), -height - 0.3**2 / height * np.log(0.3 / r))

    frame = cq.Smooth(beyond, second_derivative=1.2)
    found = enclosed(cq.Membrane(lattice, 1.0, load=0.0, support=ball, frame_height=frame))
    assert found.proven
    assert_holds(found, beyond(lattice.node_x, lattice.node_y))
    touched = found.contact
    assert touched.area.lower <= np.pi * 0.3**2 <= touched.area.upper


@pytest.mark.parametrize(
    "support",
    [
        0.05,
        Plane(0.05, 0.02, -0.03),
        Paraboloid(0.03, 2.0),
        Hemisphere(0.03, 2.0),
        cq.Smooth(lambda x, y: 0.05 + 0.01 * np.cos(3 * x) * np.sin(y), second_derivative=0.12),
    ],
    ids=["floor", "plane", "paraboloid", "hemisphere", "smooth"],
)
def test_supports_of_all_kinds_against_finer_lattices(support):
    coarse, fine = (enclosed(square(squares, support)) for squares in (12, 48))
    assert coarse.proven
    shape = 11, 47
    low, high = (getattr(coarse, end).reshape(shape[0], -1) for end in ("lower", "upper"))
    fine_low, fine_high = (getattr(fine, end).reshape(shape[1], -1)[3::4, 3::4] for end in ("lower", "upper"))
    assert (low <= fine_high).all()
    assert (fine_low <= high).all()
    assert fine.error_bound < 0.2 * coarse.error_bound
    for one, two in ((coarse, fine), (fine, coarse)):
        assert one.largest_depth.lower <= two.largest_depth.upper
        assert one.contact.reaction.lower <= two.contact.reaction.upper


def test_an_array_is_meant_as_its_interpolant():
    """Of a support with kinks nothing is certainly touched; where it hangs free is known all the same."""
    rows, columns = np.indices((11, 11))
    heights = 0.04 + 0.002 * ((rows + columns) % 3)
    found = enclosed(square(12, heights.ravel()))
    assert found.proven
    assert not found.contact.contact.any()
    assert found.contact.clear.any()
    assert found.contact.reaction.upper == np.inf
    assert np.isfinite(found.error_bound)


def test_elevations_are_depths_turned_over():
    down = enclosed(square(16))
    up = enclosed(square(16, -0.03, upwards=True))
    np.testing.assert_allclose(up.lower, -down.upper, atol=1e-12)
    np.testing.assert_allclose(up.upper, -down.lower, atol=1e-12)
    assert up.error_bound == pytest.approx(down.error_bound)


def test_a_spline_near_the_support_is_as_good_as_it_is_near():
    """Over a paraboloid both ways apply; the spline's bounds contain what the other's do."""
    model = square(16, Paraboloid(0.03, 2.0))
    posed = posed_of(Data.of(model))
    assert posed.problem.floor is None
    assert posed.rest == (0.0, 0.0)
    declared = cq.Smooth(Paraboloid(0.03, 2.0), second_derivative=0.5)
    spline = posed_of(Data.of(square(16, declared)))
    assert spline.problem.floor is not None
    assert spline.rest[0] <= 0 <= spline.rest[1] <= 3 * (1 / 16) ** 2 * 0.5 / 4
    by_load, by_spline = enclosed(model), enclosed(square(16, declared))
    assert (by_spline.lower <= by_load.upper).all()
    assert (by_load.lower <= by_spline.upper).all()


def test_what_it_tells():
    solution = cq.solve(square(32), tol=1e-9)
    found = solution.continuum("pointwise")
    text = str(found)
    assert f"{found.contact.contact.sum()} in contact, {found.contact.clear.sum()} clear" in text
    assert found._repr_html_().count("<tr>") == len(found.facts())
    for words in ("error at nodes", "squares", "largest depth", "contact area", "total reaction", "free boundary"):
        assert words in text
    assert found.error_bound >= max(
        (found.upper - solution.deflection).max(), (solution.deflection - found.lower).max()
    )
    plain = solution.continuum()
    with pytest.raises(AttributeError, match=r"lower needs solution.continuum\(effort='pointwise'\), this is 'energy'"):
        _ = plain.lower


def test_the_bounds_as_a_dataset_and_as_a_picture(tmp_path):
    found = enclosed(square(16))
    dataset = found.to_dataset()
    assert dict(dataset.sizes) == {"y": 17, "x": 17, "y_square": 18, "x_square": 18, "side": 2}
    inner = dataset["deflection_lower"].to_numpy()
    np.testing.assert_array_equal(inner[~np.isnan(inner)], found.lower)
    state = dataset["contact_state_in_squares"]
    assert np.isnan(state).sum() == 18**2 - 16**2
    assert (state == 1).sum() == found.contact.contact.sum()
    assert dataset["error_bound"] == found.error_bound
    assert dataset["error_bound"].attrs["units"] == "length"
    np.testing.assert_array_equal(dataset["x_square_bounds"].mean("side"), dataset["x_square"])
    dataset.to_netcdf(tmp_path / "bounds.nc")
    figure = found.plot(title="a bowl")
    assert figure.axes[0].get_title() == "a bowl"
    labels = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert labels == ["certainly clear", "undecided", "certainly in contact"]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"ceiling": -0.1}, "a ceiling"),
        ({"foundation": 1.0}, "an elastic foundation"),
        ({"tension": (1.0, 2.0)}, "a tension that varies, or is not the same along x and y"),
        ({"tension": lambda x, y: 1 + x**2}, "a tension that varies"),
        ({"support": np.inf}, "parts without a support"),
    ],
)
def test_what_is_not_covered_is_refused_in_words(changes, words):
    solution = cq.solve(square(8, **changes))
    with pytest.raises(ValueError, match=f"one tension over one support, not one with {words}"):
        solution.continuum("pointwise")
