"""Triangle meshes: parts, surface graph, ray casting, winding, axes, depth profiles."""
