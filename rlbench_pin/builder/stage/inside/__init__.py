"""What runs in the process of the stage: the world, and what is asked of it."""
