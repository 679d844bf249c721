"""The judge and the certificates: what an answer is worth, proven from the problem's own data."""
