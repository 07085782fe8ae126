"""Cameras, lights, textures and pictures."""
