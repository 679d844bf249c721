"""The explorer's page: one file that asks for nothing, in a browser, by its sliders."""

import json
import re

import pytest
from browser import CHROMIUM, Page
from typer.testing import CliRunner

import contactqp as cq
from contactqp.cli.commands import app
from contactqp.explorer.presets import presets

pytest.importorskip("bokeh")
needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    lattice = cq.Frame.rectangle(2.0, 1.0).lattice(spacing=0.05)
    model = cq.Membrane(lattice, tension=2.0, load=3.0, support=lambda x, y: 0.1 + 0.1 * x * x)
    return model, cq.explore(model, tmp_path_factory.mktemp("page") / "explorer.html", title="A <b>case</b> & more")


def test_the_page_is_one_file_of_a_few_megabytes_that_refers_to_no_other(file):
    text = file[1].read_text(encoding="utf-8")
    assert len(text) < 3e6
    tags = re.sub(r"(<script[^>]*>).*?</script>", r"\1", text, flags=re.DOTALL)  # scripts hold tags in their texts
    assert not re.findall(r"<(?:script|img|iframe)[^>]* src=|<link[^>]* href=\"(?!data:,)", tags)
    assert "default-src 'none'" in text
    assert "<h1>A &lt;b&gt;case&lt;/b&gt; &amp; more</h1>" in text


def test_what_is_no_page_is_refused_before_anything_is_made(tmp_path):
    with pytest.raises(ValueError, match=r"cannot write the page .*x\.pdf: unknown suffix '\.pdf'; known: \.html"):
        cq.explore(None, tmp_path / "x.pdf")
    result = CliRunner().invoke(app, ["explore", str(tmp_path / "no-case.toml"), "--out", str(tmp_path / "x.txt")])
    assert (result.exit_code, "--out: cannot write the file" in result.stderr) == (2, True)


def names_of(page):
    """Return the names of a page's scenes."""
    [records] = re.findall(r'id="contactqp-scenes">(.*?)</script>', page.read_text(encoding="utf-8"), flags=re.DOTALL)
    return [record["name"] for record in json.loads(records)]


def test_no_two_scenes_have_one_name(tmp_path):
    cable = cq.Cable(nodes=9, spacing=1.0, tension=1.0, load=1.0, support=1.0)
    names = names_of(cq.explore(cable, tmp_path / "x.html", title="cable"))
    assert names[0] == "cable (the case)"
    assert len(set(names)) == len(names) == 6


def test_the_command_tells_what_it_has_written(tmp_path):
    out = tmp_path / "cable.html"
    result = CliRunner().invoke(app, ["explore", "examples/cable.toml", "--out", str(out)])
    assert re.fullmatch(rf"explorer: {re.escape(str(out))} \(\d\.\d MB\)\n", result.stdout), result.output
    assert names_of(out)[0] == "cable over a flat floor"
    result = CliRunner().invoke(app, ["explore", "examples/pipeline_bending.toml", "--out", str(out)])
    assert (result.exit_code, "the explorer shows a Membrane or a Cable, got Beam" in result.stderr) == (2, True)


def test_a_report_links_an_explorer_of_its_case(tmp_path):
    (tmp_path / "with sliders").mkdir()
    page, report = tmp_path / "with sliders" / "cable & floor.html", tmp_path / "report.html"
    options = ["--backends", "psor", "--tol", "1e-3", "--report", str(report), "--explorer", str(page)]
    result = CliRunner().invoke(app, ["compare", "examples/cable.toml", *options])
    assert result.exit_code == 0, result.output
    assert f"explorer: {page}" in result.stdout
    assert '<a href="with%20sliders/cable%20%26%20floor.html">' in report.read_text(encoding="utf-8")
    assert page.exists()


FACTS = "contactqp.facts()"
MAP = """(() => {
  const map = Bokeh.documents[0].get_model_by_name("map");
  return Array.from(map.renderers[0].data_source.data.state[0]).filter((state) => state === 3).length;
})()"""


TOOLTIPS = """globalThis.contactqpTooltips = (root = document) =>
  [...root.querySelectorAll("*")].map((element) =>
    (String(element.className).includes("bk-Tooltip") ? (element.shadowRoot ?? element).textContent : "") +
    (element.shadowRoot ? contactqpTooltips(element.shadowRoot) : "")).join(" ")"""


def counts(model):
    """Return how many nodes are in contact and clear by Python."""
    contact = cq.solve(model, tol=1e-9).contact
    return contact.sum(), (~contact).sum()


def text_of(name):
    return f"document.getElementById('contactqp-{name}').textContent"


VIEW = "Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name({name!r}).id)"
BOX = ".getBoundingClientRect().toJSON()"


def drag_to(page, name, share):
    """Move the handle of a slider to a place along it."""
    view = VIEW.format(name=name)
    way, handle = (page.ask(f"{view}.shadow_el.querySelector('.noUi-{part}'){BOX}") for part in ("base", "handle"))
    start = handle["x"] + handle["width"] / 2, handle["y"] + handle["height"] / 2
    page.drag(start, (way["x"] + share * way["width"], start[1]))


@pytest.mark.slow
@needs_browser
def test_a_slider_is_moved_and_the_map_is_that_of_python(file):
    model, path = file
    with Page(path) as page:
        first = page.wait(f"{FACTS} !== null && {FACTS}")
        assert (first["contact"], first["clear"]) == counts(model)
        assert page.ask(MAP) == first["contact"]

        drag_to(page, "load", 0.8)
        moved = page.wait(f"{FACTS}.load !== 3 && {FACTS}")
        loaded = cq.Membrane(model.lattice, tension=2.0, load=moved["load"], support=model.support)
        assert moved["load"] > 6
        assert moved["contact"] > first["contact"]
        assert (moved["contact"], moved["clear"], moved["undecided"]) == (*counts(loaded), 0)
        assert page.ask(MAP) == moved["contact"] == float(page.ask(text_of("contact")))

        page.wait(f"{FACTS}.raced")  # both methods have come to the bound
        assert float(page.ask(text_of("relaxation-bound"))) <= 1.1e-9

        page.ask("Bokeh.documents[0].get_model_by_name('scene').value = 'the paper\\'s hexagon'")
        hexagon = page.wait(f"{FACTS}.scene.includes('hexagon') && {FACTS}")
        assert (hexagon["load"], hexagon["contact"], hexagon["clear"]) == (0.03, 303, 1554)
        label = f"{VIEW.format(name='map')}.el.getAttribute('aria-label')"
        assert page.ask(label) == "Map of the nodes: 303 in contact, 1554 clear, 0 undecided."

        page.ask("Bokeh.documents[0].get_model_by_name('play').active = true")  # the load grows
        page.wait(f"{FACTS}.load !== 0.03 && {FACTS}.contact !== 303")
        page.ask("Bokeh.documents[0].get_model_by_name('play').active = false")

        disk = next(scene.model for scene in presets() if scene.name == "disk")
        page.ask("Bokeh.documents[0].get_model_by_name('scene').value = 'disk'")
        page.wait(f"{FACTS}.scene === 'disk' && {FACTS}.contact === {counts(disk)[0]}")
        assert page.complaints == []


@pytest.mark.slow
@needs_browser
def test_a_node_tells_its_proven_bounds(file):
    with Page(file[1], 390, 844) as page:
        page.wait(f"{FACTS} !== null && {FACTS}")
        page.ask(TOOLTIPS)
        page.ask(f"{VIEW.format(name='map')}.el.scrollIntoView()")
        box = page.ask(f"{VIEW.format(name='map')}.el{BOX}")
        page.point(box["x"] + 0.5 * box["width"], box["y"] + 0.45 * box["height"])
        text = page.wait("contactqpTooltips().includes('proven at most') && contactqpTooltips()")
        numbers = dict(re.findall(r"(gap|proven at least|proven at most): *([-\d.e]+)", text))
        assert float(numbers["proven at least"]) <= float(numbers["gap"]) <= float(numbers["proven at most"])
        assert page.ask("document.documentElement.scrollWidth") == 390
        assert page.complaints == []


@pytest.mark.slow
@needs_browser
def test_of_a_cable_nothing_is_said_of_a_map(tmp_path):
    cable = cq.Cable(nodes=9, spacing=1.0, tension=1.0, load=1.0, support=1.0)
    with Page(cq.explore(cable, tmp_path / "x.html")) as page:
        page.wait(f"{FACTS} !== null && document.readyState === 'complete'")
        text = page.ask("document.querySelector('main').innerText")
        assert "From end to end" in text
        assert "map" not in text
        assert "from frame to frame" not in text
        page.ask("Bokeh.documents[0].get_model_by_name('scene').value = 'disk'")
        text = page.wait("document.querySelector('main').innerText")
        assert "click the map" in text
        assert "From end to end" not in text
