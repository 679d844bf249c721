"""Stiffnesses: what is known of a matrix G, and how it acts on a vector."""
