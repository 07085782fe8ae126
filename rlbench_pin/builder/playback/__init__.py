"""Stretches of simulation: how they are recorded frame by frame, and how recordings are shown."""
