"""Projected successive over-relaxation: own numerics, which know nothing of backends and judges."""
