"""Paths of configurations, played step by step."""
