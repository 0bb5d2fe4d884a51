"""Drawing a face: OpenGL renderers, cameras and light, windows, and what Dear ImGui lays over them."""
