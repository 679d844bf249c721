"""A backend that calls a library is a short file: what all of them have in common stands in their base."""

import ast
import io
import tokenize
from importlib import import_module
from pathlib import Path

import pytest

from contactqp.backends import BY_NAME, TABLE

MOST = 60
SILENT = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
OWN = {
    "contactqp.backends.psor",
    "contactqp.backends.multigrid",
    "contactqp.backends.active_set",
    "contactqp.backends.mprgp",
}
LIBRARIES = sorted({place.split(":")[0] for place in (*TABLE.values(), *BY_NAME.values())} - OWN)


def code_lines(source):
    """Return the numbers of the lines of a module that hold code: no blanks, comments, docstrings and imports."""
    left_out: set[int] = set()
    for node in ast.walk(ast.parse(source)):
        text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
        if isinstance(node, ast.stmt) and (text or isinstance(node, (ast.Import, ast.ImportFrom))):
            left_out.update(range(node.lineno, node.end_lineno + 1))
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in SILENT:
            lines.update(range(token.start[0], token.end[0] + 1))
    return sorted(lines - left_out)


@pytest.mark.parametrize("module", LIBRARIES)
def test_a_backend_that_calls_a_library_is_a_short_file(module):
    lines = code_lines(Path(import_module(module).__file__).read_text(encoding="utf-8"))
    assert len(lines) <= MOST


def test_what_counts_as_a_line_of_code():
    source = '''"""Text of
the module."""

import ast
from io import (
    StringIO,
)

# why
LIMIT = 3  # counts
"""What it is."""


class Thing:
    """Text."""

    def work(
        self, text="""two
        lines""",
    ):
        import sys

        return text
'''
    assert code_lines(source) == [10, 14, 17, 18, 19, 20, 23]
