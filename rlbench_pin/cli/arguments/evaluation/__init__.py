"""What the commands about evaluation take."""
