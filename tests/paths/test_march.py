"""Damped models in time: steps by hand, orders, American puts, loads in time, checkpoints, tables and films."""

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import contactqp as cq
from contactqp.cli.commands import app
from contactqp.foundation.progress import Progress
from contactqp.paths import march as march_module

CABLE = cq.Cable(span=10.0, spacing=0.5, tension=1.0, load=1.0, support=4.0)
TIMES = np.linspace(0.0, 10.0, 21)


def one_node(load=1.0, support=np.inf, **options):
    """G = 2T/h = 1, and one unit of length a node."""
    return cq.Cable(nodes=1, spacing=1.0, tension=0.5, load=load, support=support, **options)


def test_steps_of_euler_by_hand():
    """(c/Δt + 1) w = p + (c/Δt) w_old with c = 2 and Δt = 1: w = (1 + 2 w_old)/3."""
    history = cq.march(one_node(), times=[0, 1, 2], damping=2.0, method="euler", initial=0.5)
    np.testing.assert_allclose(history.deflections[:, 0], [0.5, 2 / 3, 7 / 9], rtol=1e-12)


def test_steps_of_crank_and_nicolson_by_hand():
    """Halves of Euler, w = (1 + 2 w_old)/3 for c = 1, and from the third step on w = (2 + w_old)/3."""
    history = cq.march(one_node(), times=[0, 1, 2, 3, 4], damping=1.0)
    np.testing.assert_allclose(history.deflections[:, 0], [0, 5 / 9, 65 / 81, 227 / 243, 713 / 729], rtol=1e-12)


def test_a_foundation_of_the_models_own_by_hand():
    """k = 1 beside the arms' 1: (c/Δt + 2) w = p + (c/Δt) w_old."""
    history = cq.march(one_node(foundation=1.0), times=[0, 1], damping=2.0, method="euler", initial=1.0)
    np.testing.assert_allclose(history.deflections[:, 0], [1.0, 0.75], rtol=1e-12)


def test_the_support_by_hand():
    """It would go to 2/3 but for the support at 1/2, whose reaction is what is left: 1 - 1/2 - 2 (1/2 - 1/4) = 0."""
    history = cq.march(one_node(load=2.0, support=0.5), times=[0, 1, 2], damping=2.0, method="euler", initial=0.25)
    np.testing.assert_allclose(history.deflections[:, 0], [0.25, 0.5, 0.5])
    np.testing.assert_allclose(history.reactions[:, 0], [1.0, 1.5])


def test_a_load_that_stays_takes_no_memory_for_each_time():
    """Of many times and nodes they would be gigabytes, whose copying no Ctrl-C would end."""
    loads = march_module._loads_at(CABLE, None, lambda time: CABLE.load, np.zeros(1000))
    assert loads.strides[0] == 0
    np.testing.assert_array_equal(loads[-1], CABLE.load)
    history = cq.march(one_node(), times=[0, 1, 2], damping=1.0)
    np.testing.assert_array_equal(history.loads, np.ones((3, 1)))
    np.testing.assert_array_equal(history.to_dataset()["load"], np.ones((3, 1)))


def decay_error(method, steps):
    """A sine without a load decays by exp(-λt), λ = (4T/h²) sin²(πh/2L)/c of the nodes' own equations."""
    cable = cq.Cable(span=1.0, spacing=0.05, tension=2.0, load=0.0, support=np.inf)
    start = np.sin(np.pi * cable.node_x)
    history = cq.march(
        cable, times=np.linspace(0, 0.5, steps + 1), damping=3.0, method=method, initial=start, tol=1e-12
    )
    rate = 4 * 2.0 / 0.05**2 * np.sin(np.pi * 0.05 / 2) ** 2 / 3.0
    return np.abs(history.deflections[-1] - np.exp(-rate * 0.5) * start).max()


@pytest.mark.parametrize(("method", "order"), [("euler", 1), ("crank-nicolson", 2)])
def test_orders_in_time(method, order):
    errors = [decay_error(method, steps) for steps in (20, 40, 80)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert order - 0.1 < orders[-1] < order + 0.25


STOCK, RATE = 40.0, 0.0488
PUTS = {
    (35, 0.2): (0.0062, 0.2004, 0.4328),
    (40, 0.2): (0.8522, 1.5798, 1.9904),
    (45, 0.2): (5.0000, 5.0883, 5.2670),
    (35, 0.3): (0.0774, 0.6975, 1.2198),
    (40, 0.3): (1.3099, 2.4825, 3.1696),
    (45, 0.3): (5.0597, 5.7056, 6.2436),
    (35, 0.4): (0.2466, 1.3460, 2.1549),
    (40, 0.4): (1.7681, 3.3874, 4.3526),
    (45, 0.4): (5.2868, 6.5099, 7.3830),
}
"""American puts by strike and volatility, for expiries of 0.0833, 0.3333 and 0.5833 years: the problems of Geske and
Johnson (*The American put option valued analytically*, J. Finance 39, 1984), with the values that a binomial tree of
10,000 steps gives (Huang, Subrahmanyam and Yu, *Pricing and hedging American options: a recursive integration method*,
Rev. Financial Studies 9, 1996)."""


def american_put(strike, volatility, expiry, half=600, steps=50):
    """A put as a cable: with x = ln S/K and V = e^(αx) u, α = 1/2 - r/σ², the equation of Black and Scholes is
    u_τ = (σ²/2) u_xx - k u, k = r + (r - σ²/2)²/2σ², and exercise at any time is the support e^(-αx) max(K - S, 0)."""
    drift = RATE - volatility**2 / 2
    alpha = -drift / volatility**2
    foundation = RATE + drift**2 / (2 * volatility**2)
    place = np.log(STOCK / strike)
    spacing = 4.5 * volatility * np.sqrt(expiry) / half
    if place:
        spacing = abs(place) / round(abs(place) / spacing)  # stock and strike are nodes

    def exercised(x, y):
        return strike * np.exp(-alpha * x) * np.maximum(1 - np.exp(x), 0.0)

    cable = cq.Cable(
        nodes=2 * half - 1, spacing=spacing, start=place - half * spacing, tension=volatility**2 / 2, load=0.0,
        support=exercised, frame_height=exercised, foundation=foundation, upwards=True,
    )  # fmt: skip
    ends = (0, 1 / 64, steps), (1 / 64, 1 / 8, steps), (1 / 8, 1, 2 * steps)  # shorter steps where it begins
    times = expiry * np.concatenate([[0.0], *(np.linspace(a, b, count + 1)[1:] for a, b, count in ends)])
    history = cq.march(cable, times=times, damping=1.0, initial=exercised, tol=1e-9)
    assert history.certified
    return np.exp(alpha * place) * history.deflections[-1][half - 1]


@pytest.mark.parametrize(("strike", "volatility", "which"), [(40, 0.2, 1), (45, 0.3, 2)])
def test_american_puts(strike, volatility, which):
    value = american_put(strike, volatility, (0.0833, 0.3333, 0.5833)[which])
    assert value == pytest.approx(PUTS[strike, volatility][which], abs=5.1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(("strike", "volatility"), list(PUTS))
def test_all_american_puts_of_the_table(strike, volatility):
    for expiry, value in zip((0.0833, 0.3333, 0.5833), PUTS[strike, volatility], strict=True):
        # The tree's own error shows in the last digit where values change fastest.
        room = 1.6e-4 if volatility == 0.4 else 5.1e-5
        assert american_put(strike, volatility, expiry) == pytest.approx(value, abs=room)


@pytest.mark.parametrize("method", ["euler", "crank-nicolson"])
def test_it_comes_to_rest_in_the_static_answer(method):
    static = cq.solve(CABLE, tol=1e-10)
    history = cq.march(CABLE, times=np.linspace(0, 200, 201), damping=1.0, method=method, tol=1e-10)
    assert history.certified
    np.testing.assert_allclose(history.deflections[-1], static.deflection, atol=1e-8)
    np.testing.assert_allclose(history.reactions[-1], static.reaction, atol=1e-8)
    assert history.total_reaction[-1].lower <= static.total_reaction.upper + 1e-8
    assert history.total_reaction[-1].upper >= static.total_reaction.lower - 1e-8


def test_contact_grows_under_a_load_that_stays():
    """From rest the deflection only grows, and so does contact, by the comparison of solutions."""
    history = cq.march(CABLE, times=TIMES, damping=1.0, method="euler")
    assert (np.diff(history.deflections, axis=0) >= -1e-9).all()
    contact = np.array([solution.contact for solution in history.solutions])
    assert (contact[1:] >= contact[:-1]).all()


def test_a_membrane_between_two_surfaces_and_upwards():
    lattice = cq.Frame.disk(1.0).lattice(0.2, fitted=True)
    load = {"load": lambda t: 3.0 * np.cos(t), "times": np.linspace(0, 6, 13), "damping": 0.2}
    down = cq.Membrane(lattice, (1.0, 2.0), load=1.0, support=0.2, ceiling=-0.1)
    up = cq.Membrane(lattice, (1.0, 2.0), load=1.0, support=-0.2, ceiling=0.1, upwards=True)
    history, turned = cq.march(down, **load), cq.march(up, **load)
    np.testing.assert_allclose(turned.deflections, -history.deflections, atol=1e-12)
    assert history.deflections.max() == pytest.approx(0.2, rel=1e-12)
    assert history.deflections.min() == pytest.approx(-0.1, rel=1e-12)
    assert history.certified


def test_a_net_moves():
    lattice = cq.Frame.rectangle(4, 4).lattice(1.0)
    net = cq.CableNet.orthogonal(lattice, 1.0, load=1.0, support=0.5)
    membrane = cq.Membrane(lattice, 1.0, load=1.0, support=0.5)
    moved = [cq.march(model, times=[0, 0.5, 1, 1.5], damping=1.0) for model in (net, membrane)]
    np.testing.assert_allclose(moved[0].deflections, moved[1].deflections, atol=1e-8)


def test_loads_in_time():
    by_function = cq.march(CABLE, times=TIMES, damping=1.0, load=lambda t: 0.1 * t)
    by_factors = cq.march(CABLE, times=TIMES, damping=1.0, load=0.1 * TIMES)
    np.testing.assert_allclose(by_function.deflections, by_factors.deflections, atol=1e-12)
    np.testing.assert_allclose(by_function.loads[:, 0], 0.1 * TIMES)


def test_a_support_out_of_reach_costs_no_digits():
    deep = cq.Cable(span=10.0, spacing=0.5, tension=1.0, load=1.0, support=1e30)
    free = cq.Cable(span=10.0, spacing=0.5, tension=1.0, load=1.0, support=np.inf)
    states = [cq.march(cable, times=TIMES, damping=1.0).deflections for cable in (deep, free)]
    np.testing.assert_allclose(*states, atol=1e-10)


def test_one_matrix_serves_steps_that_are_equal_to_rounding(monkeypatch):
    made = []
    monkeypatch.setattr(march_module, "with_foundation", lambda *data: made.append(1) or with_foundation(*data))
    from contactqp.models.varied import with_foundation

    cq.march(CABLE, times=0.1 * np.arange(31), damping=1.0)
    assert len(made) == 1


def test_a_checkpoint_resumes(tmp_path, monkeypatch):
    file = tmp_path / "march.nc"
    whole = cq.march(CABLE, times=TIMES, damping=1.0, backend="psor")
    asked = []

    class Killed(Progress):
        def update(self, detail=None):
            asked.append(detail)
            if len(asked) > 8:
                raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(march_module, "Progress", Killed)
        with pytest.raises(KeyboardInterrupt):
            cq.march(CABLE, times=TIMES, damping=1.0, backend="psor", checkpoint=file)
    again = cq.march(CABLE, times=TIMES, damping=1.0, backend="psor", checkpoint=file)
    np.testing.assert_allclose(again.deflections, whole.deflections, atol=1e-7)
    notes = ["restored" in solution.run.note for solution in again.solutions]
    assert notes == [True] * 6 + [False] * 14
    with pytest.raises(ValueError, match="another"):
        cq.march(CABLE, times=TIMES, damping=2.0, backend="psor", checkpoint=file)


def test_what_was_kept_for_another_load_is_not_taken(tmp_path):
    file = tmp_path / "march.nc"
    cq.march(CABLE, times=[0, 1, 2, 3], damping=1.0, load=[1, 1, 1, 1], checkpoint=file)
    other = cq.march(CABLE, times=[0, 1, 2, 3], damping=1.0, load=[1, 1, 1, 2], checkpoint=file)
    fresh = cq.march(CABLE, times=[0, 1, 2, 3], damping=1.0, load=[1, 1, 1, 2])
    np.testing.assert_allclose(other.deflections, fresh.deflections, atol=1e-7)
    assert other.certified


def test_table_dataset_and_text():
    lattice = cq.Frame.rectangle(2, 1).lattice(0.25)
    membrane = cq.Membrane(lattice, 1.0, load=1.0, support=0.05)
    history = cq.march(membrane, times=[0, 0.1, 0.2, 0.3], damping=1.0)
    frame = history.to_frame()
    assert frame.index.name == "time"
    assert frame.index.tolist() == [0.1, 0.2, 0.3]
    assert "3 steps of crank-nicolson, each certified given the one before" in repr(history)
    assert "<table" in history._repr_html_()
    data = history.to_dataset()
    assert data["deflection"].dims == ("time", "y", "x")
    assert data.sizes["time"] == 4
    np.testing.assert_array_equal(lattice.gather(data["deflection"][-1].to_numpy()), history.deflections[-1])
    assert not data["contact"][0].any()
    assert data["load"].attrs["units"] == "force per area"
    assert np.isnan(data["reaction"][0]).all()


def test_pictures_and_a_film(tmp_path):
    history = cq.march(CABLE, times=[0, 1, 2, 3], damping=1.0)
    assert history.plot().axes[2].get_xlabel() == "time"
    history.animate(tmp_path / "cable.gif", seconds=0.2)
    assert (tmp_path / "cable.gif").stat().st_size > 1000


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"times": [0.0]}, "at least two"),
        ({"times": [0.0, 1.0, 1.0]}, "1 follows 1"),
        ({"times": [0.0, np.nan]}, "times"),
        ({"damping": 0.0}, "damping must be > 0, but is 0 at node 0"),
        ({"method": "leapfrog"}, "leapfrog"),
        ({"load": [1.0, 2.0]}, "a factor for each of the 3 times"),
        ({"initial": 5.0}, "initial must lie between support and ceiling, but is 5 at node 0 .* where 4 is"),
    ],
)
def test_arguments(arguments, told):
    with pytest.raises(ValueError, match=told):
        cq.march(CABLE, **({"times": [0.0, 1.0, 2.0], "damping": 1.0} | arguments))


def test_only_models_move():
    with pytest.raises(TypeError, match="model must be"):
        cq.march(CABLE.problem, times=[0, 1], damping=1.0)


def test_the_command(tmp_path):
    case = tmp_path / "cable.toml"
    case.write_text('model = "cable"\nspan = 10.0\nspacing = 0.5\ntension = 1.0\nload = 1.0\nsupport = 4.0\n')
    out = tmp_path / "cable.nc"
    arguments = ["march", str(case), "--times", "0:2:4", "--damping", "1", "--out", str(out)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert "4 steps of crank-nicolson" in result.output
    with xr.open_dataset(out, engine="netcdf4") as data:
        assert data["time"].to_numpy().tolist() == [0.0, 0.5, 1.0, 1.5, 2.0]
    wrong = CliRunner().invoke(app, ["march", str(case), "--times", "0..2", "--damping", "1"])
    assert wrong.exit_code == 2
    assert "--times must be" in wrong.output
