"""Cameras, lights, textures and images."""
