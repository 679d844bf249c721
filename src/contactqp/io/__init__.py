"""Formats: case files, the data files that they name, and datasets."""
