"""What the browser shows of a task that is being edited."""
