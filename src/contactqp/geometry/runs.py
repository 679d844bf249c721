"""Runs: nodes that follow each other in a row of a lattice, as compiled passes take them."""

from __future__ import annotations

ROW, FIRST, LAST, NODE, KIND = range(5)
"""Columns of an array of runs: its row, its first column, one past its last, the number of its first node, and the kind
of its nodes."""

FREE, SUPPORTED, BOUNDED = range(3)
"""Kinds of nodes: without bounds; with the lower bound 0 alone; with bounds that have to be looked up."""
