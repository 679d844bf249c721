"""Primal-dual active set method for any sparse M-matrix, with direct solves or algebraic multigrid inside."""
