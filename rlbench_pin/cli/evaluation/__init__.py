"""Commands about how well something does on the tasks."""
