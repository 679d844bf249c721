"""The built documentation site: its links and pictures, and what a browser makes of it. "make docs" builds it."""

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

import pytest
from browser import CHROMIUM, Page
from searches import SEARCHES

SITE = Path(__file__).resolve().parent.parent / "build" / "site"
TEMPLATE = "webpack-macros.html"
"""A file of the theme's, which is no page."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not (SITE / "index.html").exists(), reason="the site is not built; make docs builds it"),
]
in_a_browser = pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium")

ON_A_PHONE = (
    "index",
    "start/five-minutes",
    "howto/own-matrix",
    "howto/ci",
    "howto/explore",
    "theory/certificate",
    "pictures/plot_cable",
    "notebooks/01_quickstart",
    "api/generated/contactqp.solve",
    "backends",
    "benchmarks",
    "command-line",
)


class Contents(HTMLParser):
    """Links, anchors and pictures of a page."""

    def __init__(self, page):
        super().__init__()
        self.links, self.anchors, self.pictures = [], set(), []
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        told = dict(attrs)
        if "id" in told:
            self.anchors.add(told["id"])
        if tag == "a" and told.get("href"):
            self.links.append(told["href"])
        if tag == "img":
            self.pictures.append(told)


@pytest.fixture(scope="module")
def pages():
    return {page: Contents(page) for page in SITE.rglob("*.html") if page.name != TEMPLATE}


def test_every_link_within_the_site_leads_somewhere(pages):
    lost = []
    for page, contents in pages.items():
        for link in contents.links:
            file, anchor = urldefrag(link)
            if ":" in file:
                continue
            target = (page.parent / unquote(file)).resolve() if file else page
            known = pages.get(target)
            if not target.exists() or (anchor and known is not None and unquote(anchor) not in known.anchors):
                lost.append((page.relative_to(SITE).as_posix(), link))
    assert lost == []


def test_every_picture_is_there_and_says_what_it_shows(pages):
    for page, contents in pages.items():
        for picture in contents.pictures:
            assert picture.get("alt", "").strip(), (page, picture["src"][:80])
            assert picture["src"].startswith("data:") or (page.parent / picture["src"]).exists(), picture["src"]


def open_page(browser, name, query=""):
    browser.open(f"{(SITE / f'{name}.html').as_uri()}{query}")


@in_a_browser
def test_somebody_finds_the_way_from_page_to_page():
    with Page(SITE / "index.html") as browser:
        for words, title in (
            ("How do I …", "How do I …"),
            ("Solve with a matrix of my own", "Solve with a matrix of my own"),
            ("Theory", "Theory"),
            ("The certificate", "The certificate"),
            ("API reference", "API reference"),
            ("Notebooks", "Notebooks"),
        ):
            browser.wait("document.readyState === 'complete'")
            link = f"[...document.querySelectorAll('a')].find(each => each.textContent.trim() === {words!r})"
            browser.wait(f"!!{link}")
            browser.ask(f"{link}.click()")
            browser.wait(f"(document.querySelector('h1')?.textContent || '').startsWith({title!r})")
        assert browser.complaints == []


DONE = "document.querySelector('#search-results p.search-summary')?.textContent.startsWith('Search finished')"
FOUND = "[...document.querySelectorAll('#search-results ul.search li > a')].map(each => each.getAttribute('href'))"
SEARCHED = "Search._performSearch(...Search._parseQuery({!r})).slice(-5).map(([name]) => name)"
"""The names of the first five pages, the best last, as the page of results shows them."""


@in_a_browser
def test_each_recipe_is_found_by_search():
    with Page(SITE / "search.html") as browser:
        open_page(browser, "search", "?q=pipeline")
        browser.wait(DONE)
        shown = [link.partition(".html")[0] for link in browser.ask(FOUND)[:5]]
        assert shown == browser.ask(SEARCHED.format("pipeline"))[::-1]
        missed = {
            words: (recipe, first)
            for recipe, queries in SEARCHES.items()
            for words in queries
            if f"howto/{recipe}" not in (first := browser.ask(SEARCHED.format(words)))
        }
        assert browser.complaints == []
    assert missed == {}


@in_a_browser
def test_pages_are_as_wide_as_a_phone():
    with Page(SITE / "index.html", 390, 844) as browser:
        for name in ON_A_PHONE:
            open_page(browser, name)
            assert browser.ask("document.documentElement.scrollWidth") <= 390, name
        assert browser.complaints == []


@in_a_browser
def test_there_is_a_dark_mode():
    with Page(SITE / "index.html") as browser:
        background = "getComputedStyle(document.body).backgroundColor"
        browser.ask("document.documentElement.dataset.theme = 'light'")
        light = browser.ask(background)
        browser.ask("document.documentElement.dataset.theme = 'dark'")
        assert browser.ask(background) != light
