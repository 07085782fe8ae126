"""Saved states of tasks: of one instant, and portable to another process."""
