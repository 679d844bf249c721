"""Runs: nodes that follow each other in a row of a lattice, as compiled passes take them."""

from __future__ import annotations

ROW, FIRST, LAST, NODE, KIND, HOLD = range(6)
"""Columns of an array of runs: its row, its first column, one past its last, the number of its first node, the kind of
its nodes, and how they are held beside the arms between them."""

FREE, SUPPORTED, BOUNDED = range(3)
"""Kinds of nodes: without bounds; with the lower bound 0 alone; with bounds that have to be looked up."""

KINDS = 3

LOOSE, HELD, STIFF = range(3)
"""How nodes are held: by their arms alone; by springs as well; by springs so stiff that neighbours hardly move them."""
