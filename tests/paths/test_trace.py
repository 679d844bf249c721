"""Load paths: monotone contact, warm starts, checkpoints, touchdown loads."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import contactqp as cq
from contactqp.models.varied import with_lift, with_load, with_tension
from contactqp.paths import trace as path_module

HEXAGON = cq.gallery.paper_hexagon(1.0)
CONTACT = [105, 225, 303, 553, 711, 847, 925, 971, 1033, 1107]


@pytest.fixture(scope="module")
def traced():
    return cq.trace(HEXAGON, loads=cq.gallery.PAPER_LOADS, backend="psor", cold=True)


def test_contact_only_grows_under_a_growing_load(traced):
    frame = traced.to_frame()
    assert frame["contact"].tolist() == CONTACT
    assert (frame["status"] == "certified").all()
    assert traced.monotone
    assert traced.promised
    assert (np.diff(traced.max_deflection) >= -1e-9).all()
    assert (frame["total_reaction_lower"] <= frame["total_reaction_upper"]).all()
    assert frame["cold_iterations"].sum() > frame["iterations"].sum()
    assert frame.index.name == "load"
    assert repr(traced).endswith("no violation of monotonicity")


@pytest.mark.parametrize("backend", ["osqp", "clarabel", "multigrid", "active-set"])
def test_all_backends_find_the_same_contact_sets(traced, backend):
    other = cq.trace(HEXAGON, loads=cq.gallery.PAPER_LOADS, backend=backend, tol=1e-8)
    for one, two in zip(traced.solutions, other.solutions, strict=True):
        np.testing.assert_array_equal(one.contact, two.contact)


@pytest.mark.slow
def test_the_linear_program_finds_them_too(traced):
    other = cq.trace(HEXAGON, loads=cq.gallery.PAPER_LOADS, backend="mangasarian")
    assert other.to_frame()["contact"].tolist() == CONTACT


def test_fields_are_on_the_net_and_the_load(traced):
    data = traced.to_dataset()
    assert data["gap"].dims == ("load", "y", "x")
    assert data["gap"].shape == (10, 49, 65)
    assert data["contact_fraction"].dims == ("load",)
    np.testing.assert_allclose(data["active_load"].sel(load=0.03).max(), 0.03)
    assert data.attrs["parameter"] == "load"


def test_tensions_and_lifts_vary_the_model():
    tensions = cq.trace(cq.gallery.paper_hexagon(1.0), tensions=[10.0, 40.0, 20.0])
    assert tensions.to_frame()["contact"].tolist() == [1107, 265, 711]
    assert tensions.monotone
    lifts = cq.trace(cq.gallery.paper_hexagon(0.03), lifts=[0.0, 0.1])
    assert lifts.monotone
    np.testing.assert_allclose(
        lifts.solutions[1].deflection, cq.solve(with_lift(cq.gallery.paper_hexagon(0.03), 0.1)).deflection, atol=1e-6
    )
    assert with_tension(HEXAGON, 2.0).problem.G[0, 0] == 8.0
    assert HEXAGON.tension == 1.0
    assert with_load(HEXAGON, 0.5).load[0] == 0.5


def test_rounding_of_the_data_is_no_violation():
    assert cq.trace(cq.gallery.paper_hexagon(0.03), lifts=np.arange(0, 0.5, 0.05), tol=1e-9).monotone
    assert cq.trace(cq.gallery.spiral(15), tensions=[1, 2, 3, 5, 7], tol=1e-9).monotone
    assert cq.trace(cq.gallery.ball(15)[0], tensions=[1.0, 2, 3, 5, 7, 11], tol=1e-9).monotone


def test_violations_are_found_where_nothing_is_promised():
    """P = λ(1, -1) over f = (1, -1/2): node 1 lifts at λ = 3/2 and rises with the load."""
    cable = cq.Cable(nodes=2, spacing=1.0, tension=1.0, load=[1.0, -1.0], support=[1.0, -0.5])
    path = cq.trace(cable, loads=[1.0, 2.0, 3.0])
    assert not path.promised
    assert not path.monotone
    assert path.findings[0].startswith("the gap grows between load 1 and 2, by at least 0.17 at node 1")
    assert path.findings[1].startswith("1 node(s) lift off between load 1 and 2, the first node 1")
    assert "nothing else was promised" in repr(path)
    with pytest.raises(
        ValueError, match="touchdown loads need a path that is promised to be monotone, but the load also pulls upwards"
    ):
        path.touchdown()


def test_an_interrupted_path_is_resumed(tmp_path, monkeypatch):
    file = tmp_path / "path.nc"
    calls = []

    class Interrupted(cq.Solver):
        def solve_varied(self, subject, *args):
            calls.append(float(subject.load[0]))
            if len(calls) == 3:
                raise KeyboardInterrupt
            return super().solve_varied(subject, *args)

    monkeypatch.setattr(path_module, "Solver", Interrupted)
    loads = [0.01, 0.02, 0.03, 0.04]
    with pytest.raises(KeyboardInterrupt):
        cq.trace(HEXAGON, loads=loads, checkpoint=file)
    with xr.open_dataset(file, engine="netcdf4") as kept:
        assert kept["value"].to_numpy().tolist() == [0.01, 0.02]
    path = cq.trace(HEXAGON, loads=loads, checkpoint=file)
    assert calls == [0.01, 0.02, 0.03, 0.03, 0.04]
    assert path.to_frame()["contact"].tolist() == CONTACT[:4]
    assert path.solutions[0].note == "restored from path.nc"
    assert path.to_frame()["iterations"].min() > 0
    cq.trace(HEXAGON, loads=[0.01, 0.025], checkpoint=file)
    assert calls[-1] == 0.025
    assert [file] == list(tmp_path.iterdir())
    with xr.open_dataset(file, engine="netcdf4") as kept:
        assert kept["value"].to_numpy().tolist() == [0.01, 0.02, 0.03, 0.04, 0.025]


def test_a_resumed_path_keeps_to_what_is_asked_for(tmp_path):
    """Answers that are no longer good enough are solved again, and cold iterations counted where they were not."""
    file, loads = tmp_path / "path.nc", [0.01, 0.02]
    cq.trace(HEXAGON, loads=loads, backend="psor", tol=1e-2, checkpoint=file)
    path = cq.trace(HEXAGON, loads=loads, backend="psor", tol=1e-9, checkpoint=file, on_failure="raise", cold=True)
    assert [solution.status.value for solution in path.solutions] == ["certified", "certified"]
    assert min(path.cold_iterations) > 0
    with pytest.raises(ValueError, match="on_failure must be one of"):
        cq.trace(HEXAGON, loads=loads, backend="psor", checkpoint=file, on_failure="xx")
    with pytest.warns(cq.ContactWarning, match="iteration limit"):
        cq.trace(HEXAGON, loads=[0.05], backend="psor", max_iter=2)


def test_transposed_lattices_have_checkpoints_of_their_own(tmp_path):
    def model(shape):
        return cq.Membrane(cq.Lattice(np.ones(shape, dtype=bool), 1.0), 1.0, load=1.0, support=0.0)

    cq.trace(model((2, 3)), loads=[1.0], checkpoint=tmp_path / "path.nc")
    with pytest.raises(ValueError, match="belongs to another model"):
        cq.trace(model((3, 2)), loads=[1.0], checkpoint=tmp_path / "path.nc")


def test_foreign_checkpoints_are_refused(tmp_path):
    file = tmp_path / "path.nc"
    cq.trace(HEXAGON, loads=[0.01], checkpoint=file)
    with pytest.raises(ValueError, match="belongs to another model, parameter or backend"):
        cq.trace(cq.gallery.paper_hexagon(2.0), loads=[0.01], checkpoint=file)
    with pytest.raises(ValueError, match="belongs to another"):
        cq.trace(HEXAGON, loads=[0.01], backend="psor", checkpoint=file)
    file.write_text("nonsense")
    with pytest.raises(ValueError, match=r"path\.nc is no checkpoint"):
        cq.trace(HEXAGON, loads=[0.01], checkpoint=file)
    with pytest.raises(ValueError, match="there is no folder"):
        cq.trace(HEXAGON, loads=[0.01], checkpoint=tmp_path / "no" / "path.nc")


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({}, ValueError, "give exactly one of loads, tensions and lifts, got none of them"),
        ({"loads": [1.0], "lifts": [1.0]}, ValueError, "got loads, lifts"),
        ({"loads": []}, ValueError, "loads must be a sequence of numbers"),
        ({"loads": [1.0, 1.0]}, ValueError, "must not repeat a value"),
        ({"loads": [np.nan]}, ValueError, "loads must be finite"),
        ({"tensions": [0.0]}, ValueError, "tensions must be > 0, got 0"),
        ({"loads": [1.0], "backend": "ossqp"}, cq.UnknownBackendError, "did you mean 'osqp'"),
        ({"loads": [1.0], "backend": "psor", "bta": 1}, TypeError, "no option 'bta'"),
        ({"model": HEXAGON.problem, "loads": [1.0]}, TypeError, "model must be a model, as Membrane, Cable or Beam"),
    ],
)
def test_bad_arguments_say_what_is_wrong(arguments, error, message):
    with pytest.raises(error, match=message):
        cq.trace(**({"model": HEXAGON} | arguments))


def test_touchdown_brackets_contain_the_exact_events(traced):
    touchdown = traced.touchdown(width=2e-3)
    assert touchdown.width <= 2e-3
    exact = cq.events(HEXAGON, stop=0.1, start=0.01).touchdown
    settled = np.isfinite(touchdown.load)
    assert settled.sum() == CONTACT[-1] - CONTACT[0]
    assert (touchdown.clear[settled] <= exact[settled]).all()
    assert (exact[settled] <= touchdown.contact[settled]).all()
    assert np.isnan(exact[np.isinf(touchdown.contact)]).all()
    assert "1002 nodes settle between them" in repr(touchdown)
    assert touchdown.to_dataset()["load"].dims == ("y", "x")


def test_touchdown_loads_without_bisection_are_those_of_the_path(traced):
    touchdown = traced.touchdown()
    assert touchdown.loads.tolist() == list(cq.gallery.PAPER_LOADS)
    assert touchdown.width == pytest.approx(0.01)


@pytest.mark.parametrize("loads", [[0.1, 10.0], [0.0, 10.0], [0.0, 1.0, 10.0]])
def test_touchdown_loads_by_hand(loads):
    """The three nodes of a cable settle at 1/2, 5 and 7, also where these are middles of brackets."""
    cable = cq.Cable(nodes=3, spacing=1.0, tension=1.0, load=1.0, support=[3.0, 1.0, 4.0])
    touchdown = cq.trace(cable, loads=loads).touchdown(width=1e-6)
    assert touchdown.width <= 1e-6
    np.testing.assert_allclose(touchdown.load, [5.0, 0.5, 7.0], atol=1e-6)
    assert isinstance(touchdown.plot(), Figure)
    with pytest.raises(ValueError, match="this one's parameter is the lift"):
        cq.trace(cable, lifts=[0.0, 1.0]).touchdown()
    with pytest.raises(ValueError, match="width must be > 0"):
        cq.trace(cable, loads=[1.0]).touchdown(width=0.0)


def test_paths_are_drawn(traced):
    figure = traced.plot()
    assert {axes.get_ylabel() for axes in figure.axes} == {
        "nodes in contact, fraction", "total reaction", "deflection of the lowest node", "sweeps of psor",
    }  # fmt: skip
    picture = traced.plot_touchdown()
    assert "Touchdown loads, known to 0.01" in picture.axes[0].get_title()


def test_nets_of_cables_have_paths_too(tmp_path):
    """The orthogonal net settles node by node as the membrane does."""
    lattice = cq.Frame.rectangle(6, 6).lattice(1.0)
    membrane = cq.Membrane(lattice, 1.0, load=1.0, support=1.0)
    net = cq.CableNet.orthogonal(lattice, tension=1.0, load=1.0, support=1.0)
    loads = [0.1, 0.5, 1.0, 2.5]
    path = cq.trace(net, loads=loads, checkpoint=tmp_path / "net.nc")
    assert path.to_frame()["contact"].tolist() == cq.trace(membrane, loads=loads).to_frame()["contact"].tolist()
    exact = cq.events(net, stop=3.0).touchdown
    np.testing.assert_allclose(exact, cq.events(membrane, stop=3.0).touchdown)
    touchdown = path.touchdown(width=1e-3)
    np.testing.assert_allclose(touchdown.load, exact, atol=1e-3)
    assert touchdown.to_dataset()["load"].dims == ("node",)
    assert isinstance(touchdown.plot(), Figure)
    assert path.to_dataset()["gap"].dims == ("load", "node")
    with pytest.raises(TypeError, match="a tension can be given to a Membrane or a Cable only"):
        cq.trace(net, tensions=[1.0])
