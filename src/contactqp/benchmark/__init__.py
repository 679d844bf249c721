"""A benchmark of solvers on contact problems: each in a process of its own, every answer judged against the truth.

``contactqp bench`` on the command line; from Python::

    from contactqp import benchmark

    results = benchmark.run("quick", "results", backends=["psor", "multigrid"])
    benchmark.write_report(results)

A `Spec` is a benchmark of parts: phases that are timed in turn in one process; ``contactqp bench run`` measures those
that a Python file defines.
"""

from ..gallery.families import FAMILIES, Family
from .difference import Difference, difference
from .record import Record
from .report import write_report
from .results import Results
from .runner import run
from .spec_runs import run_specs
from .specs import Phase, Spec, Timing, load_specs, solution_facts, time_point
from .statistics import growths, profile, shifted_geometric_mean, summaries
from .suites import SUITES, Suite

__all__ = [
    "FAMILIES",
    "SUITES",
    "Difference",
    "Family",
    "Phase",
    "Record",
    "Results",
    "Spec",
    "Suite",
    "Timing",
    "difference",
    "growths",
    "load_specs",
    "profile",
    "run",
    "run_specs",
    "shifted_geometric_mean",
    "solution_facts",
    "summaries",
    "time_point",
    "write_report",
]
