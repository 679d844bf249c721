"""Programs that interrupt themselves while a backend works."""

import subprocess
import sys
import textwrap

PROMPTLY = 3.0
"""Seconds in which Ctrl-C is answered, or a limit kept, at the latest: one, but for a busy machine."""

PROGRAM = """
    import os, signal, threading, time
    import numpy as np
    import contactqp as cq
    # A shell that starts the tests in the background has children that ignore it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    model = cq.gallery.bowl({nodes})
    cq.solve(cq.gallery.islands(), {name!r})
    cq.certify(model.problem, np.zeros(model.problem.size), effort="fast")  # compiles on a fresh machine
    model.problem.G
    at = []
    def interrupt():
        time.sleep({after})
        at.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)
    threading.Thread(target=interrupt, daemon=True).start()
    try:
        cq.solve(model, {name!r}, tol={tol}, on_failure="ignore")
    except KeyboardInterrupt:
        print("interrupted after", time.perf_counter() - at[0], flush=True)
    else:
        print("finished", flush=True)
    os._exit(0)
"""


def seconds_to_answer(name, nodes, tol, after=1.0):
    """Return how long a solve of a bowl by a backend takes to answer Ctrl-C, which comes after some seconds."""
    program = textwrap.dedent(PROGRAM.format(name=name, nodes=nodes, tol=tol, after=after))
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False)
    outcome = run.stdout.splitlines()[-1]
    assert outcome.startswith("interrupted after "), run
    return float(outcome.split()[-1])
