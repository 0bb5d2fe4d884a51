"""Dear ImGui: context, renderer backend, input backend, panels over the image, charts."""
