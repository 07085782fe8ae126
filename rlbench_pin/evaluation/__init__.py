"""How well something does on the tasks: controllers on the legs of demonstrations."""
