"""One model under many loads: load paths, touchdown loads, events."""
