"""The panels of the start window."""
