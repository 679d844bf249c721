"""Execute the notebooks of this folder from a clean kernel and rewrite them in place, outputs included.

Run it after a change of the package that alters numbers or pictures; it needs the extra ``contactqp[notebooks]``::

    python notebooks/execute.py                        # all of them
    python notebooks/execute.py 01_quickstart.ipynb    # some of them

Time stamps, widget state and the kernel's version are left out to keep differences small. A cell that fails stops the
run with its traceback, and its notebook stays as it was.
"""

import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

FOLDER = Path(__file__).resolve().parent


def execute(path: Path) -> None:
    """Execute the notebook at ``path`` in its own folder and write it back."""
    notebook = nbformat.read(path, as_version=4)
    # Level 40: no note about unencrypted local sockets on the terminal.
    quiet = ["--IPKernelApp.log_level=40"]
    client = NotebookClient(notebook, kernel_name="python3", timeout=300, coalesce_streams=True, extra_arguments=quiet)
    client.execute(cwd=str(FOLDER))
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    notebook.metadata = {
        "kernelspec": notebook.metadata.get("kernelspec", kernel),
        "language_info": {"name": "python"},
    }
    for cell in notebook.cells:
        cell.metadata = {}
    nbformat.write(notebook, path)


if __name__ == "__main__":
    for name in sys.argv[1:] or sorted(path.name for path in FOLDER.glob("*.ipynb")):
        execute(FOLDER / name)
        print(f"executed {name}")
