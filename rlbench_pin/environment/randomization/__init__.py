"""Domain randomization: what may change, when, and the change itself."""
