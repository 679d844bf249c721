"""A program that a signal interrupts at moments of its work; it prints how late each came, and what still works then.

Arguments: what to do, the seconds until each signal comes, the first of which meets work whose libraries are not loaded
yet, and "uncaught" if one more is to end the program.
"""

import os
import signal
import sys
import threading
import time
import warnings

import numpy as np

import contactqp as cq

warnings.simplefilter("ignore")
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have started it as one that ignores it


def hexagon(load=0.03):
    return cq.gallery.paper_hexagon(load=load)


def bowl(nodes):
    lattice = cq.Frame.rectangle(1.0, 1.0).lattice(spacing=1 / nodes)
    return cq.Membrane(lattice, tension=1.0, load=4.0, support=0.1)


WORK = {
    "osqp": lambda: cq.solve(bowl(100), "osqp"),
    "clarabel": lambda: cq.solve(bowl(100), "clarabel"),
    "mangasarian": lambda: cq.solve(bowl(30), "mangasarian"),
    "psor": lambda: cq.solve(bowl(160), "psor"),
    "multigrid": lambda: cq.solve(bowl(300), "multigrid"),
    "active-set": lambda: cq.solve(bowl(160), "active-set"),
    "matrix": lambda: cq.solve(cq.ContactQP(bowl(90).problem.G, bowl(90).problem.q)),
    "compare": lambda: cq.compare(hexagon()),
    "trace": lambda: cq.trace(hexagon(1.0), loads=np.linspace(0.01, 0.1, 100)),
    "events": lambda: cq.events(hexagon(1.0), stop=0.1),
    "march": lambda: cq.march(hexagon(), times=np.linspace(0, 100, 401), damping=1.0),
    "certify": lambda: cq.certify(bowl(160), np.full(bowl(160).lattice.size, 0.05)),
}
sent = [0.0]


def interrupt():
    sent[0] = time.perf_counter()
    os.kill(os.getpid(), signal.SIGINT)


def work_until_interrupted(what, moment):
    timer = threading.Timer(moment, interrupt)
    timer.daemon = True
    timer.start()
    while True:
        WORK[what]()


if __name__ == "__main__":
    what, *moments = (argument for argument in sys.argv[1:] if argument != "uncaught")
    for moment in map(float, moments):
        try:
            work_until_interrupted(what, moment)
        except KeyboardInterrupt:
            late = time.perf_counter() - sent[0]
        works = (cq.solve(hexagon(), name).status.value for name in ("multigrid", "psor", "clarabel", "auto"))
        print(f"{late:.3f}", *works)
    if "uncaught" in sys.argv:
        print("", end="", flush=True)
        work_until_interrupted(what, 0.5)
