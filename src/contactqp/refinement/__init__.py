"""Refinement: one model on finer and finer meshes, towards the free boundary."""
