"""The notebooks run from a clean kernel, and their committed outputs are complete."""

import re
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

FOLDER = Path(__file__).resolve().parent.parent / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))

each_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def complaints(notebook):
    """Return what a reader should not find among the outputs: errors and warnings."""
    found = []
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            if output.output_type == "error":
                found.append(f"cell {cell.id}: {output.ename}: {output.evalue}")
            elif output.output_type == "stream" and output.name == "stderr":
                found.append(f"cell {cell.id} wrote to stderr: {output.text}")
    return found


def test_notebooks_are_found():
    assert [path.name for path in NOTEBOOKS] == [
        "01_quickstart.ipynb",
        "02_solver_comparison.ipynb",
        "03_how_wrong_can_it_be.ipynb",
        "04_the_paper.ipynb",
        "05_cables_over_ground.ipynb",
        "06_load_paths_and_touchdown.ipynb",
        "07_bearing_with_cavitation.ipynb",
        "08_fabric_roof.ipynb",
        "09_pipe_with_bending.ipynb",
        "10_design_and_inverse.ipynb",
        "11_the_membrane_itself.ipynb",
    ]


@each_notebook
def test_committed_outputs_are_complete(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    counts = [cell.execution_count for cell in notebook.cells if cell.cell_type == "code"]
    assert counts == list(range(1, len(counts) + 1)), "not executed in order; run python notebooks/execute.py"
    assert complaints(notebook) == []


@pytest.mark.slow
@each_notebook
def test_notebook_runs_from_a_clean_kernel(path):
    notebook = nbformat.read(path, as_version=4)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
    failure = ""
    try:
        NotebookClient(notebook, kernel_name="python3", timeout=300).execute(cwd=str(FOLDER))
    except CellExecutionError as error:
        failure = re.sub(r"\x1b\[[0-9;]*m", "", str(error))
    if failure:
        pytest.fail(f"{path.name}: {failure}", pytrace=False)
    assert complaints(notebook) == []
