"""Dear ImGui: its renderer, its input, charts."""
