"""The panels: each draws one tab, replaces the controller's state, and calls its methods."""
