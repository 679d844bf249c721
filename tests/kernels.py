"""Compiles every kernel of the package, or the halves of them that are named, for all who find them in the cache.

numba's cache lets two processes that compile for different types give one name to both results, and hands out what an
older source left under the name that a new result is about to get. So tests that run side by side find all compiled.
"""

import sys
from importlib import import_module
from itertools import product
from typing import get_args

PRECISIONS = ("float32", "float64")


def lattice():
    from contactqp.methods.multigrid import galerkin_kernels, lattice_kernels

    for kind in get_args(lattice_kernels.ArmKind):
        if kind != "varying":
            galerkin_kernels.coarsen_lattice(kind)
        lattice_kernels.lattice_kernels(kind)
        for precision in PRECISIONS:
            lattice_kernels.exchange_kernels(kind, precision)


def others():
    from contactqp.methods.amg import aggregation
    from contactqp.methods.multigrid import level_kernels, weighted_kernels
    from contactqp.proof import lattice_measure_kernels

    for module in (
        *("algebra.band_kernels", "algebra.conductance_kernels", "geometry.numbering_kernels"),
        *("methods.active_set.case_kernels", "methods.amg.sparse_kernels", "methods.multigrid.rim_kernels"),
        "methods.sor.kernels",
    ):
        import_module(f"contactqp.{module}")
    for springs in (False, True):
        lattice_measure_kernels.passes(springs)
    aggregation._compiled()
    weighted_kernels.weighted_kernels()
    for own, coarser in product(PRECISIONS, repeat=2):
        level_kernels.level_kernels(own, coarser)
        level_kernels.transfer_kernels(own, coarser)


HALVES = {"lattice": lattice, "others": others}

if __name__ == "__main__":
    for half in sys.argv[1:] or HALVES:
        HALVES[half]()
