"""Recordings of simulation and their display in a browser: 3D models of a scene, a player, pages without an editor."""
