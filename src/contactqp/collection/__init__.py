"""The collection: problems with proved answers, as files that other programs read."""
