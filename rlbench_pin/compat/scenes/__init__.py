"""What environments and scenes under their known names are made of."""
