"""Formulas as MathML, which browsers draw by themselves: pages load no script for them, and need no network."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util.math import get_node_equation_number


def inline(self: Any, node: nodes.Element) -> None:
    """Write a formula within a line."""
    self.body.append(convert(node.astext()))
    raise nodes.SkipNode


def display(self: Any, node: nodes.Element) -> None:
    """Write a formula on lines of its own, with its number; a long one is scrolled by itself on a narrow screen."""
    kind = "math displayed numbered" if node["number"] else "math displayed"
    self.body.append(self.starttag(node, "div", CLASS=kind))
    if node["number"]:
        number = get_node_equation_number(self, node)
        self.body.append(f'<span class="eqno">({number})')
        self.add_permalink_ref(node, "Link to this equation")
        self.body.append("</span>")
    for part in node.astext().split("\n\n"):
        if part.strip():
            self.body.append(convert(_aligned(part), display="block"))
    self.body.append("</div>\n")
    raise nodes.SkipNode


def _aligned(formula: str) -> str:
    """Several lines, or places where they are to stand below each other, need an environment that the library knows."""
    if r"\begin{" not in formula and (r"\\" in formula or "&" in formula):
        return rf"\begin{{align*}}{formula}\end{{align*}}"
    return formula.replace("{aligned}", "{align*}")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer: ``html_math_renderer = "mathml"``."""
    app.add_html_math_renderer("mathml", (inline, None), (display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
