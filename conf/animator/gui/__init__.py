"""The animator's user interface in Dear ImGui: layout, theme, widgets, panels."""
