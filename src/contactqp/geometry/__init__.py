"""Frames, lattices, the numbering of nodes, and fields given on them."""
