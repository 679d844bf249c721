"""A file that tests have another process run, as the package has PETSc's worker: it answers what it is told to.

It is asked as `contactqp.backends.in_files` asks, and is run by this interpreter.
"""

import os
import sys
import time
from pathlib import Path

import numpy as np

from contactqp.backends.petsc_worker import _answer, _awaited

folder = Path(sys.argv[1])
(folder / f"{os.getpid()}.pid").touch()
number = 0
while True:
    asked = _awaited(folder, number, os.getppid())
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
    _answer(folder, number, 0, 1 if method == "twice" else None, {"told": told})
    number += 1
