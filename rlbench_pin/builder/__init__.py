"""The task builder: edit a task in the browser, validate it, and save it as its scene file and its Python file."""
