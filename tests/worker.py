"""A file that tests have another process run, as the package has PETSc's worker: it answers what it is told to.

It is asked as `contactqp.backends.in_files` asks, run by this interpreter; of the package it loads that one file.
"""

import os
import runpy
import sys
import time
from pathlib import Path

import numpy as np

SOURCE = Path(__file__).parents[1] / "src" / "contactqp" / "backends" / "petsc_worker.py"


def answer_all(folder, parent):
    """Answer whatever comes, until there is nothing more."""
    real = runpy.run_path(str(SOURCE))
    (folder / f"{os.getpid()}.pid").touch()
    number = 0
    while True:
        asked = real["_awaited"](folder, number, parent)
        if asked is None:
            break
        method, told, arrays = asked["method"], asked["settings"], asked["arrays"]
        if method == "twice":
            np.save(folder / f"{number}.npy", 2.0 * arrays["gap"])
        elif method == "wait":
            time.sleep(60.0)
        elif told.get("words"):
            sys.stderr.write(told["words"])
            sys.stderr.flush()
            os._exit(7)
        real["_answer"](folder, number, 0, 1 if method == "twice" else None, {"told": told})
        number += 1


if __name__ == "__main__":
    answer_all(Path(sys.argv[1]), int(sys.argv[2]))
