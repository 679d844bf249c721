"""The HTML page: complete, self-contained, well-formed, and shown by a browser where there is one."""

import base64
import re
import shutil
import subprocess
from html.parser import HTMLParser
from io import BytesIO

import matplotlib.image
import numpy as np
import pytest
from strategies import touching_softly

import contactqp as cq
from contactqp.comparison.comparison import Comparison
from contactqp.solving.tolerances import Tolerance

CHROMIUM = shutil.which("chromium")
VOID = {"meta", "link", "img", "br"}


class Page(HTMLParser):
    """Elements with attributes and text, and every tag that is closed in the wrong place."""

    def __init__(self, text):
        super().__init__()
        self.open, self.wrong, self.elements, self.texts = [], [], [], {}
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)

    def handle_data(self, data):
        if self.open:
            self.texts.setdefault(self.open[-1], []).append(data)

    def all(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]


@pytest.fixture(scope="module")
def comparison():
    return cq.compare(
        touching_softly(31, 0.01),
        ["osqp", "clarabel", "psor", "mangasarian"],
        tol="default",
        options={"osqp": {"rho": 0.01, "polishing": True}, "mangasarian": {"cost": np.linspace(1, 2, 961)}},
        repeats=1,
    )


@pytest.fixture(scope="module")
def text(comparison, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "page.html"
    assert comparison.report(path, title="Soft <contact> & more") == path
    assert [file.name for file in path.parent.iterdir()] == ["page.html"]
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def test_the_page_is_well_formed(text, page):
    assert text.startswith('<!DOCTYPE html>\n<html lang="en">')
    assert page.wrong == []
    assert page.open == []
    assert page.texts["title"] == page.texts["h1"] == ["Soft <contact> & more"]
    tables, captions = page.all("table"), page.texts["caption"]
    assert len(tables) == len(captions) >= 9
    assert all(heading.get("scope") in ("row", "col") for heading in page.all("th"))
    assert all(len(image["alt"]) > 40 for image in page.all("img"))
    assert {"viewport", None} == {meta.get("name") for meta in page.all("meta")}


def test_nothing_points_outside(text, page):
    assert page.all("script") == []
    for tag, attributes in page.elements:
        for name, value in attributes.items():
            if name in ("src", "href", "action", "data", "poster", "srcset"):
                assert value.startswith("data:"), (tag, name, value[:40])
            assert not name.startswith("on"), (tag, name)
    style = "".join(page.texts["style"])
    assert "url(" not in style
    assert "@import" not in style
    assert re.findall(r"https?:", text) == []


def test_what_it_tells(comparison, text, page):
    cells = page.texts["td"] + page.texts["th"]
    for name in ("osqp", "clarabel", "psor", "mangasarian"):
        assert cells.count(name) >= 6
    headings = page.texts["h2"]
    assert headings == [
        "What each backend reached", "Where the truth lies", "Findings and false claims", "Pairs",
        "Where the answers lie apart", "Worst nodes", "Settings", "Versions and machine",
    ]  # fmt: skip
    assert text.index('class="verdict') < text.index("<img") < text.index("<table")
    paragraphs = " ".join(page.texts["p"])
    assert comparison.verdict() in paragraphs
    decided = comparison.decided
    assert f"{decided['contact']} are certainly in contact, {decided['clear']} certainly clear" in paragraphs
    items = " ".join(page.texts["li"])
    assert "polish made the answer worse" in items
    assert all(sentence in items for sentence in comparison.false_claims.values())
    unproven = len(comparison.unproven_claims)
    assert f"Said to be solved, which is not proven ({unproven})" in page.texts["h3"]
    assert any(cell.startswith("the library's own defaults; given: rho = 0.01, polishing = True") for cell in cells)
    for package in ("contactqp", "Python", "numpy", "scipy", "numba", "osqp", "clarabel", "platform", "processors"):
        assert package in cells
    assert comparison.provenance.when.strftime("%Y-%m-%d") in text


def test_every_number_of_a_row_is_there(comparison, page):
    cells = page.texts["td"]
    for row in comparison.rows:
        for value in (row.relative_bound, row.gap_bound, row.natural_residual, row.relative_true_error):
            assert f"{value:.2g}" in cells
        low, high = f"{row.true_error_lower:.2g}", f"{row.true_error_upper:.2g}"
        assert (low if low == high else f"{low} to {high}") in cells
        assert f"{row.warm_seconds:#.3g}" in cells


def test_the_pictures_are_pictures(page):
    images = page.all("img")
    assert len(images) == 2
    for image in images:
        kind, data = image["src"].split(",")
        assert kind == "data:image/png;base64"
        pixels = matplotlib.image.imread(BytesIO(base64.b64decode(data)))
        assert pixels.shape[:2] == (int(image["height"]), int(image["width"]))
        assert np.unique(pixels.reshape(-1, pixels.shape[2]), axis=0).shape[0] > 50


def test_nobody_and_one_alone_have_reports_too(tmp_path):
    for backends in ([], ["psor"]):
        islands = cq.gallery.islands()
        comparison = cq.compare(islands, backends) if backends else Comparison(islands, [], Tolerance(1e-6))
        page = Page(comparison.report(str(tmp_path / "r.html")).read_text(encoding="utf-8"))
        assert (page.wrong, page.open) == ([], [])
        assert page.texts["h1"] == [comparison.subject]
        assert "There are no two answers to compare." in page.texts["p"]
        assert len(page.all("img")) == len(backends)


def test_a_matrix_a_cable_and_rows_without_an_answer(tmp_path, monkeypatch):
    monkeypatch.setattr("contactqp.algebra.band.MOST_ENTRIES", 2)
    tied = cq.ContactQP(0.1 * np.eye(3) + 0.9, [-1.0, 0.0, 0.0])
    comparison = cq.compare(tied, ["psor", "clarabel", "mangasarian", "auto"])
    page = Page(comparison.report(tmp_path / "r.html").read_text(encoding="utf-8"))
    assert (page.wrong, page.open) == ([], [])
    assert "the library's own defaults" not in page.texts["td"]
    assert any("no answer has a certificate" in paragraph for paragraph in page.texts["p"])
    assert "unsuitable" in page.texts["td"]
    shipped = cq.compare(tied, ["osqp", "clarabel"], tol="default").report(tmp_path / "r.html")
    assert Page(shipped.read_text(encoding="utf-8")).texts["td"].count("the library's own defaults") == 2
    cable, _ = cq.gallery.cable_on_floor(nodes=9, contact_starts_after=2)
    page = Page(cq.compare(cable, ["psor", "auto"], tol="default").report(tmp_path / "r.html").read_text("utf-8"))
    assert (page.wrong, page.open) == ([], [])


def test_a_page_is_replaced_as_a_whole(tmp_path, monkeypatch):
    path = tmp_path / "r.html"
    path.write_text("old")
    comparison = cq.compare(cq.gallery.islands(), ["psor"])
    with monkeypatch.context() as patch:
        patch.setattr("contactqp.comparison.html._pairs", lambda comparison: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            comparison.report(path)
    assert path.read_text() == "old"
    comparison.report(path)
    assert path.read_text(encoding="utf-8").endswith("</html>\n")
    assert [file.name for file in tmp_path.iterdir()] == ["r.html"]
    with pytest.raises(ValueError, match=r"cannot write the report .*nowhere/r.html: there is no folder .*make it"):
        comparison.report(tmp_path / "nowhere" / "r.html")


def browse(folder, *arguments):
    """Run a browser that asks nobody for anything, with a profile of its own."""
    quiet = ("--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update")
    return subprocess.run(
        [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", *quiet, "--disable-sync",
         f"--user-data-dir={folder / 'profile'}", *arguments],
        capture_output=True, check=True, timeout=120,
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium")
def test_a_browser_shows_the_page(text, tmp_path):
    path = tmp_path / "page.html"
    path.write_text(text, encoding="utf-8")
    shown = browse(tmp_path, "--dump-dom", path.as_uri()).stdout.decode()
    parsed, original = Page(shown), Page(text)
    # A browser mends what is wrong, and its document would then hold other elements.
    assert [tag for tag, _ in parsed.elements] == [tag for tag, _ in original.elements]
    picture = tmp_path / "page.png"
    browse(tmp_path, f"--screenshot={picture}", "--window-size=1100,5000", "--hide-scrollbars", path.as_uri())
    pixels = matplotlib.image.imread(picture)[..., :3]
    assert pixels.shape == (5000, 1100, 3)
    # The colour of contact, and the ends of the disagreement's colour scale: both pictures were drawn.
    for colour in ((200, 85, 61), (68, 1, 84), (253, 231, 37)):
        assert (np.abs(pixels * 255 - colour).max(axis=2) < 12).sum() > 20, colour
