"""Planning problems as files."""
