"""Moving objects as triangles, drawn by numpy for all cameras of an instant at once."""
