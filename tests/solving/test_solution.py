import re
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import contactqp as cq


@pytest.fixture(scope="module")
def solution():
    return cq.solve(cq.gallery.paper_hexagon(), "clarabel")


def test_the_repr_tells_what_how_well_and_how_fast(solution):
    lines = repr(solution).splitlines()
    assert lines[0].startswith("Solution by clarabel: certified, ")
    assert re.search(r", [0-9.]+ s( and [0-9.]+ s of loading)?$", lines[0])
    assert lines[1] == "  problem     Membrane(1857 nodes, spacing=1, tension=1, load=0.03, support=0 to 1.25)"
    assert lines[2].startswith("  gap error   <= ")
    assert lines[3] == "  against     the exact solution of the discrete problem"
    assert lines[4] == "  nodes       303 in contact, 1554 clear, 0 undecided: proven of the exact solution"
    assert lines[5] == "  caution     largest slope 0.23: the theory assumes small slopes"


def test_gentle_slopes_need_no_remark():
    gentle = cq.solve(cq.Membrane(cq.Frame.rectangle(9, 9).lattice(1.0), 1.0, load=0.001, support=1.0), "clarabel")
    assert gentle.max_slope < 0.2
    assert "caution" not in repr(gentle)


def test_every_quantity_satisfies_its_definition(solution):
    model, problem = solution.model, solution.problem
    np.testing.assert_allclose(solution.deflection, model.support - solution.gap)
    np.testing.assert_allclose(solution.reaction, problem.G @ solution.gap + problem.q, atol=1e-14)
    held = np.where(solution.certificate.clear, 0.0, solution.reaction)
    np.testing.assert_array_equal(solution.contact_pressure, held)
    np.testing.assert_array_equal(solution.contact, solution.certificate.contact)
    balance = solution.force_balance
    assert balance.load == pytest.approx(balance.reaction + balance.frame)


def test_the_dataset(solution):
    data = solution.to_dataset()
    assert dict(data.sizes) == {"y": 49, "x": 65}
    assert data.gap.dims == ("y", "x")
    assert int(data.gap.notnull().sum()) == 1857
    assert data.gap.attrs["units"] == "length"
    assert data.reaction.attrs["units"] == "force"
    assert data.contact_pressure.attrs["units"] == "force per area"
    assert data.attrs["status"] == "certified"
    np.testing.assert_array_equal(data.gap.values[solution.model.lattice.mask], solution.gap)
    assert float(data.deflection.sel(x=0, y=0)) == pytest.approx(0.0, abs=1e-6)
    assert (data.gap_lower <= data.gap_upper).values[solution.model.lattice.mask].all()
    assert set(np.unique(data.contact_state.values[solution.model.lattice.mask])) == {0.0, 1.0}


def test_a_cables_dataset_is_a_line():
    cable, exact = cq.gallery.cable_on_floor(nodes=9, contact_starts_after=2)
    data = cq.solve(cable, "clarabel").to_dataset()
    assert dict(data.sizes) == {"x": 9}
    np.testing.assert_allclose(data.deflection.values, exact, atol=1e-5)
    assert data.contact_pressure.attrs["units"] == "force per length"


def test_the_dataset_survives_netcdf(solution, tmp_path):
    import xarray as xr

    solution.to_dataset().to_netcdf(tmp_path / "s.nc", engine="netcdf4")
    with xr.open_dataset(tmp_path / "s.nc", engine="netcdf4") as data:
        xr.testing.assert_identical(data.load(), solution.to_dataset())


def test_a_bare_problem_has_no_deflection():
    bare = cq.solve(cq.ContactQP(np.eye(2), [-1.0, 1.0]), "clarabel")
    np.testing.assert_allclose(bare.gap, [1.0, 0.0], atol=1e-6)
    for attribute in ("deflection", "contact_pressure", "max_slope", "force_balance"):
        with pytest.raises(AttributeError, match=f"{attribute} needs a model, as Membrane, Cable or Beam"):
            getattr(bare, attribute)
    with pytest.raises(AttributeError, match="to_dataset needs a model, as Membrane, Cable or Beam"):
        bare.to_dataset()
    assert "ContactQP(2 unknowns" in repr(bare)


def test_pictures_show_themselves_in_a_notebook():
    bare = cq.solve(cq.ContactQP(np.eye(2), [-1.0, 1.0]), "clarabel")
    figure: Any = bare.plot()
    assert figure._repr_png_().startswith(b"\x89PNG")
    assert "Gap and reaction" in texts(figure)


def texts(figure):
    found = {text.get_text() for axes in figure.axes for text in [axes.title, *axes.texts]}
    legends = [axes.get_legend() for axes in figure.axes if axes.get_legend()]
    legends += [legend for part in (figure, *figure.subfigs) for legend in part.legends]
    return found | {text.get_text() for legend in legends for text in legend.get_texts()}


def test_the_picture_of_a_membrane(solution):
    figure = solution.plot()
    assert isinstance(figure, Figure)
    assert {"Contact map", "Section at y = 0", "certainly in contact (303)", "certainly clear (1554)"} <= texts(figure)


def test_undecided_nodes_are_drawn_as_such():
    """The floor has the shape of the free cable, in whole numbers, so that gap and reaction both vanish exactly."""
    x = np.arange(1.0, 12.0)
    lattice = cq.Lattice(np.ones((11, 11), dtype=bool), 1.0)
    floor = np.tile(np.minimum(x, 6.0) * (12 - np.minimum(x, 6.0)), (11, 1))
    floor = np.where(np.arange(11)[:, None] < 8, floor, floor + 50.0)
    membrane = cq.Membrane(lattice, 1.0, load=0.0, support=np.zeros((11, 11)))
    solution = cq.solve(membrane, "psor")
    assert f"undecided ({solution.certificate.undecided.sum()})" in texts(solution.plot())
    assert solution.certificate.undecided.all()


@pytest.mark.parametrize(
    "model",
    [
        cq.gallery.cable_on_floor(nodes=9, contact_starts_after=2)[0],
        cq.gallery.islands(),
        cq.gallery.l_shape_with_hole(0.1),
        cq.Membrane(cq.Lattice.from_mask([[True]], 1.0), 1.0, load=1.0, support=0.1),
        cq.Membrane(cq.Frame.disk(1).lattice(0.2), 1.0, load=1.0, support=np.inf),
    ],
    ids=repr,
)
def test_every_model_can_be_drawn(model, tmp_path):
    figure = cq.solve(model, "clarabel").plot()
    figure.savefig(tmp_path / "picture.png", dpi=40)
    cq.compare(model, ["clarabel"]).plot().savefig(tmp_path / "comparison.svg")
    assert (tmp_path / "comparison.svg").stat().st_size > 1000


def test_a_comparison_of_a_bare_problem_can_be_drawn():
    model = cq.gallery.islands()
    figure = cq.compare(cq.ContactQP(model.problem.G, model.problem.q), ["clarabel", "psor"]).plot()
    assert "Gap and reaction" in texts(figure)


def test_a_session_refuses_a_misspelt_argument_with_the_one_that_was_meant():
    misspelt = {"loads": 1.0}
    with pytest.raises(
        TypeError, match=r"^Solver.solve has no argument 'loads'; did you mean 'load'\?; it has load, su"
    ):
        cq.Solver(cq.gallery.bowl(7)).solve(**misspelt)
