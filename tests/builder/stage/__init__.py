"""The stage of the task builder."""
