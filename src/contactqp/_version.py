"""The version: the only place in the source where it is written."""

__version__ = "0.1.0"
