"""solve() and the Solution: scale a problem, call a backend by name, judge its answer."""
