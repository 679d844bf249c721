"""Where a library is imported within a function, it has been loaded before, where Ctrl-C cannot hit it."""

import ast
from pathlib import Path

import pytest

import contactqp

SOURCE = Path(contactqp.__file__).parent
HEAVY = {
    "clarabel",
    "cvxpy",
    "highspy",
    "matplotlib",
    "meshio",
    "mpl_toolkits",
    "netCDF4",
    "osqp",
    "pandas",
    "pint",
    "pyvista",
    "qpsolvers",
    "rasterio",
    "scipy",
    "skfem",
    "shapely",
    "xarray",
    "zarr",
}
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


def unloaded_imports(tree):
    """Yield the lines of functions that import a heavy library before they load anything."""
    for function in ast.walk(tree):
        if not isinstance(function, FUNCTIONS):
            continue
        loads = [
            node.lineno
            for node in ast.walk(function)
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "load_modules"
        ]
        for node in ast.walk(function):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) and not node.level else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            heavy = HEAVY & {name.split(".")[0] for name in names}
            if isinstance(node, ast.stmt) and heavy and not any(line < node.lineno for line in loads):
                yield node.lineno


@pytest.mark.parametrize("path", sorted(SOURCE.rglob("*.py")), ids=lambda path: str(path.relative_to(SOURCE)))
def test_libraries_are_loaded_before_they_are_imported(path):
    assert list(unloaded_imports(ast.parse(path.read_text(encoding="utf-8")))) == []


def test_the_search_finds_what_it_looks_for():
    assert list(unloaded_imports(ast.parse("def work():\n    import scipy.sparse\n"))) == [2]
