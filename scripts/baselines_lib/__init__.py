"""What `make baselines` plays, and the tables of what came of it."""
