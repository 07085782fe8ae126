"""The task builder: a task is made in the browser, validated, and kept as the two files that a person would write."""
