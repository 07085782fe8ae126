"""What the numbers of an action mean."""
