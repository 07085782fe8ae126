"""From poses to configurations."""
