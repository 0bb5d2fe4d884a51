"""Finding a face in a mesh by rendering it and tracking the renderings."""
