"""What a check shows people: a Markdown page, tables and pictures."""
