"""Bodies of a scene and of the room, their joints and models."""
