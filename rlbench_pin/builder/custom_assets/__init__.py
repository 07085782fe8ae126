"""Meshes and URDF files that the user uploads: checked and converted to assets in a subprocess."""
