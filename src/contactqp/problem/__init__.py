"""ContactQP, and the facts about its matrix that proofs rest on."""
