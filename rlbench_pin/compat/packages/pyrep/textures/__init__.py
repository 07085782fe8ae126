"""Pictures on shapes."""
