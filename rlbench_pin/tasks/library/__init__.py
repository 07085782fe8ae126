"""The task library: one pair of files per task."""
