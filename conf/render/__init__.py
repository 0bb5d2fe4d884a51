"""OpenGL rendering of a face: renderers, camera, lights, windows, and Dear ImGui over the image."""
