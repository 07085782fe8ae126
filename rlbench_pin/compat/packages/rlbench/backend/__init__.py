"""What lies under environments and tasks."""
