"""Immutable editor state."""
