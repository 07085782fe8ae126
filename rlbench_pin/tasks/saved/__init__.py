"""What tasks remember: of one moment, and so that it can travel to another process."""
