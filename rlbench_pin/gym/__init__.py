"""Every task as a gymnasium environment; importing this package registers the ids."""
