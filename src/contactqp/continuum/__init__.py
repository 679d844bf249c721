"""The membrane itself: bounds of the continuous solution that hold its distance from the lattice's answer."""
