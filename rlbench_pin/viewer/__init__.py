"""Recordings of simulation and their display in a browser: figures of a scene, a player, pages without an editor."""
