"""What the classes of this package share."""
