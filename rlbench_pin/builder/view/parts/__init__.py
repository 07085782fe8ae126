"""Things that can be added to a scene: assets with their pictures, primitives, meshes of one's own."""
