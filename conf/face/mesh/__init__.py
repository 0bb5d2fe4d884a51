"""Triangle meshes: parts, graph distances, ray casting, axes, depth profiles."""
