"""What objects tell of themselves at a prompt and in a notebook: plain, whole, and without solving anything."""

import re
from base64 import b64decode
from html.parser import HTMLParser
from io import BytesIO

import numpy as np
import pytest
from matplotlib import image

import contactqp as cq
from contactqp.foundation import cards
from contactqp.plotting.states import STATE_COLOURS


class Parser(HTMLParser):
    """Counts open elements, and collects the text."""

    def __init__(self):
        super().__init__()
        self.open, self.text = [], []

    def handle_starttag(self, tag, attributes):
        assert tag not in ("script", "link", "iframe")
        if tag != "img":
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def text_of(thing):
    parser = Parser()
    html = thing._repr_html_()
    parser.feed(html)
    assert parser.open == []
    assert "http" not in html
    return " ".join("".join(parser.text).split())


@pytest.fixture(scope="module")
def membrane():
    lattice = cq.Frame.rectangle(6, 4).lattice(spacing=1.0)
    return cq.Membrane(lattice, tension=1.0, load=lambda x, y: 1.0 + 0.1 * x, support=0.9)


@pytest.fixture(scope="module")
def net():
    lattice = cq.Frame.rectangle(4, 4).lattice(spacing=1.0)
    return cq.CableNet.orthogonal(lattice, tension=1.0, load=1.0, support=0.5)


@pytest.fixture(scope="module")
def cable():
    return cq.Cable(span=10.0, spacing=1.0, tension=1.0, load=1.0, support=2.0)


def things(membrane, net, cable):
    solution = cq.solve(membrane)
    yield from (membrane, net, cable, solution, solution.certificate, cq.certify(solution.problem, solution.gap))
    yield from (cq.solve(net), cq.solve(cable), cq.solve(solution.problem), cq.compare(membrane, ["auto", "clarabel"]))
    path = cq.trace(membrane, loads=[0.5, 1.0])
    yield from (path, path.touchdown(), cq.events(cable, stop=1.0))


def test_everything_shows_itself_in_a_notebook(membrane, net, cable):
    for thing in things(membrane, net, cable):
        assert text_of(thing)
        assert repr(thing)


def test_ranges_of_load_and_support_are_told(membrane, net, cable):
    assert repr(membrane) == "Membrane(15 nodes, spacing=1, tension=1, load=0.8 to 1.2, support=0.9)"
    assert repr(net).endswith("fixed points, load=1, support=0.5)")
    assert repr(cable) == "Cable(9 nodes, spacing=1, tension=1, load=1, support=2)"
    nowhere = cq.Cable(span=4.0, spacing=1.0, tension=1.0, load=-1.0, support=np.inf)
    assert repr(nowhere) == "Cable(3 nodes, spacing=1, tension=1, load=-1, support=none, 3 unsupported)"
    told = text_of(membrane)
    assert "0.8 to 1.2 (force per area, positive downwards)" in told
    assert "0.9 (length, positive downwards)" in told


def test_nothing_is_solved_to_be_shown(membrane, monkeypatch):
    lattice = cq.Frame.rectangle(6, 4).lattice(spacing=1.0)
    fresh = cq.Membrane(lattice, tension=1.0, load=1.0, support=0.9)
    monkeypatch.setattr("contactqp.solving.solution.Solution.by", None)
    monkeypatch.setattr("contactqp.problem.facts.find_barrier", None)
    for thing in (fresh, fresh.problem, lattice, cq.Frame.disk(1.0), cq.Solver(fresh, "clarabel")):
        assert repr(thing)
    assert text_of(fresh)


def test_what_is_shown_is_escaped():
    told = cards.card("<script>", {"<i>": "a & b"}, "")
    assert "<script>" not in told
    assert "<i>" not in told
    assert "a &amp; b" in told


def test_a_picture_is_the_map_with_its_rows_upwards(membrane):
    lattice = cq.Frame.rectangle(8, 4).lattice(spacing=1.0)
    tilted = cq.Membrane(lattice, tension=1.0, load=1.0, support=lambda x, y: np.where(y > 0, 0.1, 9.0))
    solution = cq.solve(tilted)
    (data,) = re.findall(r"base64,([^\"]+)", solution._repr_html_())
    drawn = image.imread(BytesIO(b64decode(data)), format="png")
    assert drawn.shape[:2] == lattice.shape
    contact = np.array([int(STATE_COLOURS[1][k : k + 2], 16) for k in (1, 3, 5)]) / 255
    shown = np.isclose(drawn[..., :3], contact, atol=1e-3).all(axis=-1)
    wanted = lattice.scatter(solution.certificate.contact, fill=False).astype(bool)
    assert wanted.any()
    np.testing.assert_array_equal(shown[::-1], wanted)


def test_large_maps_are_thinned_out():
    html = cards.pixels(np.zeros((1000, 20, 3), dtype=np.uint8), "map")
    (data,) = re.findall(r"base64,([^\"]+)", html)
    assert image.imread(BytesIO(b64decode(data)), format="png").shape[0] == 250


def test_a_failed_solution_shows_itself_too(membrane):
    solution = cq.solve(membrane, "psor", max_iter=1, tol=1e-12, on_failure="ignore")
    told = text_of(solution)
    assert "advice" in told
    assert "iteration limit" in told


def test_comparing_objects_never_raises(membrane, net, cable):
    for thing in things(membrane, net, cable):
        assert thing == thing
        assert (thing == 3) is False
        assert not np.any(thing == np.zeros(3))
    one, other = cq.solve(membrane), cq.solve(membrane)
    for part, its in ((one, other), (one.run, other.run), (one.verdict, other.verdict)):
        assert part == part
        assert part != its


def test_completion_shows_what_is_public():
    shown = {name for name in dir(cq) if not name.startswith("_")}
    assert shown == {*cq.__all__, "benchmark", "mpi", "testing", "xarray"}
    assert all(hasattr(cq, name) for name in shown)
    assert cq.testing.assert_encloses
    with pytest.raises(AttributeError, match="no attribute 'missing'"):
        _ = cq.missing


def test_help_opens_with_what_the_package_does():
    first, *_ = cq.__doc__.split("\n\n")
    assert "Membranes and cables over rigid obstacles" in first
    assert "pytest" not in cq.__doc__.split("PYTEST")[0]
