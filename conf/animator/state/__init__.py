"""Immutable editor state, one module a panel of the window."""
