"""Joints, cameras, paths and remembered places of the things of a world."""
