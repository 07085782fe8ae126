"""Modules below environments and tasks."""
