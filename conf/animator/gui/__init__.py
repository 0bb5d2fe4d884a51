"""The animator's window in Dear ImGui: layout, theme, widgets, panels."""
