"""Algebraic multigrid by smoothed aggregation."""
