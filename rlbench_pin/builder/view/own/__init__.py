"""Meshes and URDF files of one's own: checked and made anew in a process apart, then put beside the task."""
