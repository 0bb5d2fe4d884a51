"""A window on a display, and one in memory with the same interface."""
