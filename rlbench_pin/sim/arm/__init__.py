"""The simulated arm and hand."""
