"""Controllers on the legs of demonstrations: each follows the same motions."""
