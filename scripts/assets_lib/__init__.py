"""Parts of `build_assets.py`: meshes, URDF writing and one module per family of objects."""
