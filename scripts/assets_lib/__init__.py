"""What `build_assets.py` is made of: meshes, URDF writing and one module per family of objects."""
