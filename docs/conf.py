"""How the documentation site is built: ``make docs``. No page needs a network, and every warning is an error."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent
sys.path[:0] = [str(ROOT / "src"), str(HERE / "_extensions")]
os.environ["PYTHONPATH"] = str(ROOT / "src")

import contactqp  # noqa: E402

project = "contactqp"
author = "The contactqp developers"
project_copyright = author
version = release = contactqp.__version__

extensions = [
    "mathml",
    "docstrings",
    "pictures",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_nb",
    "matplotlib.sphinxext.plot_directive",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_extensions", "_extra", "_unreleased.md", "_templates", "_static", "gallery", "pictures/*.ipynb"]
templates_path = ["_templates"]
default_role = "autolink"
nitpicky = True

# Types are told in words by the docstrings, and other projects are not asked for their inventories.
autodoc_typehints = "none"
autodoc_preserve_defaults = True
autodoc_mock_imports = [name for name in ("torch", "jax") if importlib.util.find_spec(name) is None]
nitpick_ignore_regex = [
    ("py:.*", r"(?!contactqp).*"),
    # What docstrings name for who reads the source:
    ("py:obj", r"contactqp\.(algebra|continuum|foundation|geometry|problem|proof|solving|studies)\..+"),
]
autosummary_ignore_module_all = False
autosummary_filename_map = {  # classes have these names with a capital, which some file systems do not tell apart
    f"contactqp.{name}": f"contactqp.{name}-function"
    for name in ("events", "study", "benchmark.difference", "jax.contact", "torch.contact")
}
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

html_math_renderer = "mathml"
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
nb_merge_streams = True
nb_execution_mode = "off"  # notebooks are executed by "make notebooks", and their outputs are tested

plot_include_source = True
plot_html_show_source_link = False
plot_html_show_formats = False
plot_formats = [("png", 110)]
sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "pictures",
    "image_scrapers": ("pictures.figures_of_example",),
    "capture_repr": ("_repr_html_", "__repr__"),
    "download_all_examples": False,
    "write_computation_times": False,
    "show_memory": False,
    "show_signature": False,
    "plot_gallery": "True",
    "abort_on_example_error": True,
    "copyfile_regex": r"$^",
}

html_theme = "pydata_sphinx_theme"
html_title = "contactqp"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_extra_path = ["_extra"]
html_show_sourcelink = False
html_copy_source = False
html_search_scorer = str(HERE / "_static" / "scorer.js")
html_show_search_summary = False  # it fetches pages, which browsers refuse to those that are opened as files
html_context = {"default_mode": "auto"}  # dark where the reader's system is
html_theme_options = {
    "navbar_align": "left",
    "header_links_before_dropdown": 6,
    "show_prev_next": True,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "back_to_top_button": False,
}
html_sidebars = {"changelog": [], "benchmarks": []}

# The notebooks lie beside this folder, and sphinx reads what lies within.
shutil.copytree(ROOT / "notebooks", HERE / "notebooks", ignore=shutil.ignore_patterns("*.py", ".*"), dirs_exist_ok=True)

# What has changed since the last release stands in a file for each change.
draft = [sys.executable, "-m", "towncrier", "build", "--draft", "--version", "unreleased"]
changes = subprocess.run(draft, cwd=ROOT, check=True, stdout=subprocess.PIPE, encoding="utf-8").stdout
_, _, listed = changes.partition("\n### ")  # before it stands a heading with the day
(HERE / "_unreleased.md").write_text(f"### {listed}" if listed else "Nothing yet.\n", encoding="utf-8")

# A page that solves in the browser, which a recipe embeds.
(HERE / "_extra").mkdir(exist_ok=True)
contactqp.explore(contactqp.gallery.paper_hexagon(), HERE / "_extra" / "explorer.html")
