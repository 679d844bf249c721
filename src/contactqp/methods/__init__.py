"""Our own numerics, which know nothing of problems, backends and judges."""
