"""Beams against closed forms: where they come down, what they transmit, and how they are held."""

from pathlib import Path

import numpy as np
import pytest

import contactqp as cq
from contactqp.models.varied import with_lift, with_load, with_tension
from contactqp.solving.solver import Solver

PINNED, CLAMPED, FREE = "pinned", "clamped", "free"
HELD = [("pinned", "pinned"), ("clamped", "clamped"), ("pinned", "clamped"), ("clamped", "free"), ("free", "clamped")]


def errors(make, counts):
    found = []
    for count in counts:
        beam, exact = make(count)
        solution = cq.solve(beam)
        assert solution.status == cq.Status.CERTIFIED
        found.append(float(np.abs(solution.deflection - exact).max()))
    return np.array(found)


@pytest.mark.parametrize("tension", [0.0, 30.0])
@pytest.mark.parametrize("end", ["pinned", "clamped"])
def test_a_heavy_beam_on_a_floor_converges_with_second_order(end, tension):
    found = errors(lambda k: cq.gallery.beam_on_floor(50 * k - 1, 13 * k, end, tension=tension), (1, 2, 4, 8))
    assert np.log2(found[0] / found[-1]) / 3 >= 1.9
    assert found[-1] < 1e-8


@pytest.mark.parametrize(("end", "factor", "share"), [("pinned", 24, 1 / 2), ("clamped", 72, 1 / 3)])
@pytest.mark.parametrize("nodes", [99, 400])
def test_touchdown_and_its_concentrated_reaction(end, factor, share, nodes):
    """It spans a = (24 EI f/p)^(1/4), or (72 EI f/p)^(1/4), and comes down with pa/2, or pa/3."""
    rigidity, load, floor, length = 3.0, 2.0, 0.4, 12.0
    spacing = length / (nodes + 1)
    beam = cq.Beam(nodes=nodes, spacing=spacing, bending_stiffness=rigidity, load=load, support=floor, ends=end)
    solution = cq.solve(beam)
    a = (factor * rigidity * floor / load) ** 0.25
    spans = beam.spans(solution)
    assert spans["kind"].tolist() == ["free", "contact", "free"]
    assert abs(spans["start"][1] - a) <= spacing
    assert abs(length - spans["end"][1] - a) <= spacing
    for column in ("force_at_start", "force_at_end"):
        assert spans[column][1] == pytest.approx(share * load * a, rel=3 * (spacing / a) ** 2)
    assert np.isnan(spans["force_at_start"][[0, 2]]).all()
    resting, concentrated = load * (length - 2 * a), spans["force_at_start"][1] + spans["force_at_end"][1]
    assert spans["reaction"][1] == pytest.approx(concentrated + resting, rel=(spacing / a) ** 2)
    # Between touchdowns, away from them, the floor carries the load and no more.
    inside = np.abs(beam.node_x - length / 2) < length / 2 - a - 4 * spacing
    np.testing.assert_allclose(solution.contact_pressure[inside], load, rtol=1e-5)
    assert solution.certificate.undecided.sum() == 0


def test_no_concentrated_reaction_is_told_where_nothing_tells_it_from_the_rest():
    """A contact of few nodes is all ends, and where a beam ends it does not come down."""
    peak = np.full(9, 1.0)
    peak[4] = 0.2
    beam = cq.Beam(10.0, spacing=1.0, bending_stiffness=5.0, load=0.3, support=peak)
    solution = cq.solve(beam)
    assert solution.contact.nonzero()[0].tolist() == [4]
    spans = beam.spans(solution)
    assert np.isnan(spans[["force_at_start", "force_at_end"]].to_numpy()).all()
    assert spans["reaction"][1] == pytest.approx(solution.reaction[4])
    board = cq.Beam(4.0, spacing=0.25, bending_stiffness=0.3, ends=("clamped", "free"), load=1.0, support=0.2)
    spans = board.spans(cq.solve(board))
    assert spans["kind"].tolist() == ["free", "contact"]
    assert np.isnan(spans["force_at_end"][1])
    assert 0 < spans["force_at_start"][1] < spans["reaction"][1]


@pytest.mark.parametrize("beside", [np.inf, 0.5])
def test_a_platform_bears_no_more_than_there_is(beside):
    """Whatever the ground is beside it, also none, enters no reaction."""
    x = np.arange(1, 100) / 100
    beam = cq.Beam(
        nodes=99, spacing=0.01, bending_stiffness=1.0, load=1.0, support=np.where(np.abs(x - 0.5) < 0.1, 0.002, beside)
    )
    spans = beam.spans(cq.solve(beam))
    assert spans["kind"].tolist() == ["free", "contact", "free"]
    start, end, whole = spans.loc[1, ["force_at_start", "force_at_end", "reaction"]]
    assert start == pytest.approx(end)
    assert 0.2 * whole < start < 0.5 * whole


def test_a_ceiling_is_pushed_as_a_floor_is():
    """Upside down: with a foundation, too, whose force at the ceiling is not that at the floor."""
    deep = 0.3**4 / 24 * 0.7
    below = cq.Beam(nodes=199, spacing=1 / 200, bending_stiffness=1.0, load=1.0, support=deep, foundation=1000.0)
    above = cq.Beam(
        nodes=199, spacing=1 / 200, bending_stiffness=1.0, load=-1.0, support=10.0, ceiling=-deep, foundation=1000.0
    )
    columns = ["reaction", "force_at_start", "force_at_end"]
    floor, ceiling = (beam.spans(cq.solve(beam)).loc[1, columns].to_numpy(float) for beam in (below, above))
    np.testing.assert_allclose(ceiling, -floor, rtol=1e-4)
    assert 0 < 2 * floor[1] < floor[0]


def test_between_floor_and_ceiling_both_touchdowns_are_of_second_order():
    errors = []
    for half in (50, 100):
        beam, _ = cq.gallery.beam_between_floor_and_ceiling(half, 3 * half // 10)
        spans = beam.spans(cq.solve(beam))
        forces = spans.loc[spans["kind"] == "contact", ["force_at_start", "force_at_end"]].to_numpy()
        assert (np.sign(forces) == [[1, 1], [-1, -1]]).all()
        errors.append(np.abs(np.abs(forces) - 0.5 * 0.3).max())
    assert errors[1] < 0.3 * errors[0] < 3e-3


def stretched(x, length, load, tension, rigidity, end):
    """Return EI w⁗ - T w″ = p between two ends that are held alike."""
    rate = np.sqrt(tension / rigidity)
    parabola = load * x * (length - x) / (2 * tension)
    half = np.cosh(rate * length / 2)
    middle = np.cosh(rate * (x - length / 2))
    if end == "pinned":
        return parabola - load / (tension * rate**2) * (1 - middle / half)
    return parabola + load * length / (2 * tension * rate * np.sinh(rate * length / 2)) * (middle - half)


@pytest.mark.parametrize("end", ["pinned", "clamped"])
def test_a_stretched_beam_without_contact_solves_its_differential_equation(end):
    length, load, tension, rigidity = 5.0, 2.0, 3.0, 0.7

    def make(nodes):
        beam = cq.Beam(
            nodes=nodes,
            spacing=length / (nodes + 1),
            bending_stiffness=rigidity,
            tension=tension,
            load=load,
            support=np.inf,
            ends=end,
        )
        return beam, stretched(beam.node_x, length, load, tension, rigidity, end)

    found = errors(make, (24, 49, 99))
    assert (np.log2(found[:-1] / found[1:]) >= 1.9).all()


@pytest.mark.parametrize("end", ["pinned", "clamped"])
def test_moment_and_shear_of_a_uniform_load(end):
    """Pinned: M = px(L - x)/2; clamped: p(6Lx - L² - 6x²)/12; both V = p(L/2 - x)."""
    length, load = 4.0, 3.0
    beam = cq.Beam(length, spacing=0.05, bending_stiffness=2.0, load=load, support=np.inf, ends=end)
    solution = cq.solve(beam)
    forces = beam.internal_forces(solution.gap)
    x = forces.x
    exact = load * x * (length - x) / 2
    if end == "clamped":
        exact = exact - load * length**2 / 12
    np.testing.assert_allclose(forces.moment, exact, atol=2e-3)
    np.testing.assert_allclose(forces.shear, load * (length / 2 - forces.arm_x), atol=1e-8)
    np.testing.assert_allclose(forces.reaction, load * (length - 0.05) / 2, rtol=1e-9)
    data = solution.to_dataset()
    assert data["bending_moment"].attrs["units"] == "force times length"
    assert data["shear"].attrs["units"] == "force"
    np.testing.assert_allclose(data["bending_moment"], forces.moment[1:-1])
    np.testing.assert_allclose(data["shear"], load * (length / 2 - beam.node_x), atol=1e-8)


def test_sagging_is_positive_whichever_way_heights_are():
    down, up = (
        cq.Beam(4.0, spacing=0.5, bending_stiffness=1.0, load=1.0, support=-0.5 if upwards else 0.5, upwards=upwards)
        for upwards in (False, True)
    )
    one, other = cq.solve(down), cq.solve(up)
    np.testing.assert_allclose(other.deflection, -one.deflection, atol=1e-12)
    for name in ("bending_moment", "shear", "reaction"):
        np.testing.assert_allclose(other.to_dataset()[name], one.to_dataset()[name], atol=1e-9)


@pytest.mark.parametrize(
    ("ends", "deflection", "reaction", "clamp"),
    [
        (("clamped", "free"), lambda x: x**2 * (24 - 8 * x + x**2) / 24, (2.0, 0.0), -2.0),
        (("free", "clamped"), lambda x: (2 - x) ** 2 * (24 - 8 * (2 - x) + (2 - x) ** 2) / 24, (0.0, 2.0), -2.0),
        (("clamped", "pinned"), lambda x: x**2 * (2 - x) * (6 - 2 * x) / 48, (1.25, 0.75), -0.5),
    ],
)
def test_other_ends_carry_what_statics_say(ends, deflection, reaction, clamp):
    """EI = p = 1, L = 2: a cantilever, and a beam that is clamped at one end."""
    found = []
    for spacing in (0.1, 0.05, 0.025):
        beam = cq.Beam(2.0, spacing=spacing, bending_stiffness=1.0, load=1.0, support=np.inf, ends=ends)
        solution = cq.solve(beam)
        found.append(np.abs(solution.deflection - deflection(beam.node_x)).max())
        forces = beam.internal_forces(solution.gap)
        held = np.array([end != "free" for end in ends])
        np.testing.assert_allclose(forces.reaction, np.array(reaction) - held * spacing / 2, atol=spacing**2)
        assert forces.moment[-1 if ends[1] == "clamped" else 0] == pytest.approx(clamp, abs=spacing**2)
        assert beam.span == pytest.approx(2.0)
        assert abs(solution.force_balance.imbalance) < 1e-12
    assert (np.log2(np.array(found[:-1]) / found[1:]) >= 1.9).all()


@pytest.mark.parametrize("ends", HELD)
@pytest.mark.parametrize("tension", [0.0, 2.0, "varying"])
def test_the_matrix_is_symmetric_definite_and_what_pull_says(ends, tension):
    rng = np.random.default_rng(7)
    stiffness, pulled = rng.uniform(0.5, 2.0, 12), rng.uniform(0.5, 2.0, 12) if tension == "varying" else tension
    beam = cq.Beam(
        nodes=12,
        spacing=0.5,
        bending_stiffness=stiffness,
        tension=pulled,
        load=1.0,
        support=1.0,
        ends=ends,
        foundation=rng.uniform(0.0, 1.0, 12 + ("free" in ends)),
    )
    matrix = beam.problem.G.toarray()
    assert (matrix == matrix.T).all()
    assert np.linalg.eigvalsh(matrix).min() > 0
    for _ in range(3):
        depths = rng.normal(size=beam.size)
        np.testing.assert_allclose(matrix @ depths, beam.pull(depths), rtol=0, atol=1e-12 * np.abs(matrix).max())
    assert beam.problem.G.nnz == 5 * beam.size - 6


def test_rows_at_the_ends_are_those_of_second_differences():
    def rows(ends):
        beam = cq.Beam(nodes=5, spacing=1.0, bending_stiffness=1.0, load=1.0, support=1.0, ends=ends)
        return beam.problem.G.toarray()

    np.testing.assert_array_equal(rows("pinned")[:3], [[5, -4, 1, 0, 0], [-4, 6, -4, 1, 0], [1, -4, 6, -4, 1]])
    np.testing.assert_array_equal(rows("clamped")[0], [7, -4, 1, 0, 0])
    np.testing.assert_array_equal(rows(("clamped", "free"))[-2:], [[0, 0, 1, -4, 5, -2], [0, 0, 0, 1, -2, 1]])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"ends": ("pinned", "free")}, r"let the beam turn about its pinned end"),
        ({"ends": "free"}, r"let the beam fall, and a foundation under two of its nodes"),
        ({"ends": "free", "tension": 1.0}, r"let the beam fall, and a foundation under one of its nodes"),
        ({"ends": "free", "foundation": [1.0] + [0.0] * 10}, "let the beam fall"),
        ({"ends": "hinged"}, r"ends\[0\] must be one of 'pinned', 'clamped', 'free', got 'hinged'"),
        ({"ends": ("pinned",)}, "ends must be a pair of 'pinned', 'clamped', 'free'"),
        ({"tension": -1.0}, "tension must be >= 0, got -1: what is compressed may buckle"),
        ({"tension": [0.0] * 9}, "tension must be finite and > 0"),
        ({"bending_stiffness": 0.0}, "bending_stiffness must be > 0"),
        ({"bending_stiffness": lambda x: 5.0 - x}, "bending_stiffness must be finite and > 0, but is 0 at x=5"),
        ({"bending_stiffness": [1.0, 2.0]}, "bending_stiffness must be a number, an array"),
        ({"ceiling": 2.0}, "ceiling must not lie below the support"),
    ],
)
def test_what_makes_no_beam_is_refused(arguments, message):
    given = {"bending_stiffness": 1.0, "load": 1.0, "support": 1.0} | arguments
    with pytest.raises((ValueError, TypeError), match=message):
        cq.Beam(5.0, spacing=0.5, **given)


@pytest.mark.parametrize(
    "arguments",
    [
        {"ends": ("pinned", "free"), "tension": 2.0},
        {"ends": ("free", "pinned"), "foundation": [0.0] * 9 + [1.0]},
        {"ends": "free", "foundation": [1.0] * 2 + [0.0] * 9},
        {"ends": "free", "foundation": [1.0] + [0.0] * 10, "tension": 3.0},
    ],
)
def test_what_else_holds_a_free_end_is_enough(arguments):
    beam = cq.Beam(5.0, spacing=0.5, bending_stiffness=1.0, load=1.0, support=0.3, **arguments)
    assert np.linalg.eigvalsh(beam.problem.G.toarray()).min() > 0
    solution = cq.solve(beam)
    assert solution.status == cq.Status.CERTIFIED
    assert abs(solution.force_balance.imbalance) < 1e-12


def test_free_ends_are_nodes_of_half_a_spacing():
    beam = cq.Beam(
        3.0, spacing=0.5, bending_stiffness=1.0, load=2.0, support=1.0, ends="free", foundation=1.0, start=-1
    )
    np.testing.assert_allclose(beam.node_x, np.arange(-1.0, 2.1, 0.5))
    np.testing.assert_allclose(beam.node_area, [0.25, 0.5, 0.5, 0.5, 0.5, 0.5, 0.25])
    assert beam.nodal_load.sum() == 6.0
    assert beam.span == 3.0
    # Nothing else holds it, so the foundation sinks by p/k everywhere, or the floor is met.
    solution = cq.solve(beam)
    np.testing.assert_allclose(solution.deflection, 1.0)
    spans = beam.spans(solution)
    assert spans["start"].iloc[0] == -1.0
    assert spans["end"].iloc[-1] == 2.0


def test_overhang_of_a_beam_on_a_foundation_is_told_to_its_free_end():
    beam = cq.Beam(4.0, spacing=0.5, bending_stiffness=1.0, load=1.0, support=0.2, ends=("clamped", "free"))
    spans = beam.spans(cq.solve(beam))
    assert spans[["start", "end"]].iloc[[0, -1]].to_numpy().ravel().tolist()[::3] == [0.0, 4.0]
    free = cq.Beam(4.0, spacing=0.5, bending_stiffness=1.0, load=1.0, support=np.inf, ends=("clamped", "free"))
    only = free.spans(cq.solve(free))
    assert only[["kind", "start", "end", "nodes"]].iloc[0].tolist() == ["free", 0.0, 4.0, 8]
    assert only["largest_moment"].iloc[0] == pytest.approx(-8.0 + 1.0, abs=1.0)


def test_stiffness_that_varies_is_that_of_each_point():
    """EI = 1 + x under a force of one at the tip of a cantilever L = 1: EI w″ = 1 - x."""
    found = []
    for spacing in (0.05, 0.025, 0.0125):
        nodes = round(1 / spacing)
        load = np.zeros(nodes)
        load[-1] = 2 / spacing  # a force of one at the free end, which stands for half a spacing
        beam = cq.Beam(
            1.0, spacing=spacing, bending_stiffness=lambda x: 1 + x, load=load, support=np.inf, ends=("clamped", "free")
        )
        x = beam.node_x
        exact = 2 * ((1 + x) * np.log1p(x) - x) - x**2 / 2
        found.append(np.abs(cq.solve(beam).deflection - exact).max())
        np.testing.assert_allclose(beam.bending_stiffness, 1 + x)
    assert (np.log2(np.array(found[:-1]) / found[1:]) >= 1.9).all()


def test_stiffness_by_an_array_that_has_both_ends_or_not():
    def beam(stiffness):
        return cq.Beam(4.0, spacing=1.0, bending_stiffness=stiffness, load=1.0, support=1.0, ends="clamped")

    np.testing.assert_array_equal(beam([1.0, 2.0, 3.0]).bending_stiffness, [1.0, 2.0, 3.0])
    assert beam([1.0, 2.0, 3.0]).problem.G[0, 0] == 2 * 1 + 4 * 1 + 2
    assert beam([5.0, 1.0, 2.0, 3.0, 5.0]).problem.G[0, 0] == 2 * 5 + 4 * 1 + 2
    assert beam([2.0, 2.0, 2.0]).bending_stiffness == 2.0


def test_between_floor_and_ceiling_the_balance_has_all_parts():
    beam = cq.Beam(
        8.0,
        spacing=0.1,
        bending_stiffness=0.05,
        tension=0.5,
        load=lambda x: np.where(x < 4, 1.0, -1.0),
        support=0.2,
        ceiling=-0.2,
        foundation=0.1,
        ends=("clamped", "pinned"),
    )
    solution = cq.solve(beam, tol=1e-9)
    assert solution.status == cq.Status.CERTIFIED
    assert solution.contact_lower.any()
    assert solution.contact_upper.any()
    assert (solution.deflection <= 0.2).all()
    assert (solution.deflection >= -0.2).all()
    balance = solution.force_balance
    assert min(balance.reaction, balance.ceiling, abs(balance.foundation), abs(balance.frame)) > 1e-3
    assert abs(balance.imbalance) < 1e-12
    assert sum(beam.internal_forces(solution.gap).reaction) == pytest.approx(balance.frame, abs=1e-9)
    kinds = beam.spans(solution)["kind"].tolist()
    assert kinds == ["free", "contact", "free", "contact", "free"]


def test_ends_at_other_heights():
    """The pinned end of a beam that is clamped at the other is held down, δ deeper, by 3 EI δ/L³."""
    beam = cq.Beam(
        2.0,
        spacing=0.02,
        bending_stiffness=1.0,
        load=0.0,
        support=np.inf,
        ends=("clamped", "pinned"),
        frame_height=lambda x: 1.0 + 0.25 * x,
    )
    solution = cq.solve(beam)
    forces = beam.internal_forces(solution.gap)
    assert forces.reaction == pytest.approx((3 * 0.5 / 8, -3 * 0.5 / 8), rel=1e-3)
    level = cq.Beam(2.0, spacing=0.2, bending_stiffness=1.0, load=0.0, support=5.0, frame_height=1.0)
    np.testing.assert_allclose(cq.solve(level).deflection, 1.0, atol=1e-10)


def test_other_loads_tensions_and_supports_of_the_same_beam():
    beam = cq.Beam(10.0, spacing=0.25, bending_stiffness=1.0, tension=0.5, load=1.0, support=0.5, ends="clamped")
    for varied, given in (
        (with_load(beam, 2.0), {"load": 2.0}),
        (with_tension(beam, 3.0), {"tension": 3.0}),
        (with_lift(beam, 0.2), {"support": 0.3}),
    ):
        arguments = {"bending_stiffness": 1.0, "tension": 0.5, "load": 1.0, "support": 0.5, "ends": "clamped"} | given
        again = cq.Beam(10.0, spacing=0.25, **arguments)
        np.testing.assert_allclose(cq.solve(varied).deflection, cq.solve(again).deflection, atol=1e-9)
        assert repr(varied) == repr(again)
    session = Solver(beam)
    for load in (1.0, 1.5):
        assert session.solve(load=load).status == cq.Status.CERTIFIED


def test_a_beam_is_told_in_words():
    beam = cq.Beam(
        5.0, spacing=0.5, bending_stiffness=2.0, tension=3.0, load=1.0, support=1.0, ends=("clamped", "free")
    )
    assert repr(beam) == (
        "Beam(10 nodes, spacing=0.5, bending_stiffness=2, tension=3, clamped - free, load=1, support=1)"
    )
    assert beam.parameters == {"bending_stiffness": 2.0, "tension": 3.0, "spacing": 0.5}
    assert "bending_stiffness" in beam._repr_html_()
    assert beam.units["bending_stiffness"] == "force times length squared"
    varying = cq.Beam(5.0, spacing=0.5, bending_stiffness=lambda x: 1 + x, load=1.0, support=1.0)
    assert "bending_stiffness=1.5 to 5.5" in repr(varying)
    assert "bending_stiffness" in cq.solve(varying).to_dataset()


def test_units_are_converted():
    pint = pytest.importorskip("pint")
    beam = cq.Beam(
        pint.Quantity(5000, "mm"),
        spacing=0.5,
        bending_stiffness=pint.Quantity(2e3, "N m**2"),
        tension=pint.Quantity(1500, "N"),
        load=1.0,
        support=1.0,
        units={"length": "m", "force": "kN"},
    )
    assert (beam.span, beam.bending_stiffness, beam.tension) == pytest.approx((5.0, 2.0, 1.5))


def test_a_uniform_tension_far_above_the_stiffness_makes_a_cable():
    given = {"spacing": 0.1, "tension": 100.0, "load": 1.0, "support": 0.1}
    beam, cable = cq.Beam(10.0, bending_stiffness=1e-8, **given), cq.Cable(10.0, **given)
    np.testing.assert_allclose(cq.solve(beam).deflection, cq.solve(cable).deflection, atol=1e-6)


@pytest.mark.parametrize("bending_stiffness", [1e4, 3e5, 1e7])
def test_stiff_pipes_on_rough_ground_come_to_rest(bending_stiffness):
    """Exchanges by double precision would creep for hundreds of steps."""
    file = Path(__file__).parents[2] / "examples" / "seabed.csv"
    ground = cq.profiles.Sampled.from_csv(file, interpolation="pchip")
    pipe = cq.Beam(
        span=2000.0, spacing=1.0, bending_stiffness=bending_stiffness, tension=400.0, load=0.7, support=ground,
        frame_height=ground,
    )  # fmt: skip
    solution = cq.solve(pipe, tol=1e-8)
    assert solution.status == "certified"
    assert solution.iterations <= 40
    assert not solution.certificate.undecided.any()
