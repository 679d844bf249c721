"""One problem, several backends, and whether they agree."""
