"""Paths around obstacles: found, shortened, smoothed."""
