"""A benchmark of solvers on contact problems: each in a process of its own, every answer judged against the truth.

``contactqp bench`` on the command line; from Python::

    from contactqp import benchmark

    results = benchmark.run("quick", "results", backends=["psor", "multigrid"])
    benchmark.write_report(results)
"""

from .difference import Difference, difference
from .families import FAMILIES, Family
from .record import Record
from .report import write_report
from .results import Results
from .runner import run
from .statistics import growths, profile, shifted_geometric_mean, summaries
from .suites import SUITES, Suite

__all__ = [
    "FAMILIES",
    "SUITES",
    "Difference",
    "Family",
    "Record",
    "Results",
    "Suite",
    "difference",
    "growths",
    "profile",
    "run",
    "shifted_geometric_mean",
    "summaries",
    "write_report",
]
