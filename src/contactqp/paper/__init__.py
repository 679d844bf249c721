"""The paper's example at the ten loads of its Table 1: ``contactqp paper``.

The rigid surface is a surrogate consistent with Table 1, not a reproduction: the paper's Fig. 4 is lost.

`reproduce` solves and scans; `write_folder` writes table, contact maps, pictures and middle sections. What the paper
itself states stands in `contactqp.paper.facts`.
"""

from ..foundation.files import made_folder as prepare_folder
from .facts import FACTORS, SURROGATE, TABLE_1, fit_cpu_time
from .folder import write_folder
from .reproduction import Reproduction, reproduce
from .scan import Scan, scan
from .sections import Section, middle_section
from .text_maps import text_map
from .theory import jacobi_radius, optimal_factor

__all__ = [
    "FACTORS",
    "SURROGATE",
    "TABLE_1",
    "Reproduction",
    "Scan",
    "Section",
    "fit_cpu_time",
    "jacobi_radius",
    "middle_section",
    "optimal_factor",
    "prepare_folder",
    "reproduce",
    "scan",
    "text_map",
    "write_folder",
]
