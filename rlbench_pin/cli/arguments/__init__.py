"""What each command takes, apart from its work, so that help need not import what the work needs."""
