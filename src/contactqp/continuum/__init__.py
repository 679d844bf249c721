"""What an answer on a lattice proves of the membrane itself."""
