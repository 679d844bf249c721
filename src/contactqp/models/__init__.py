"""Models of contact: nodes held by tension over a support, posed as a `ContactQP`."""
