"""Studies: how fast discrete answers approach the closed forms of the gallery."""
