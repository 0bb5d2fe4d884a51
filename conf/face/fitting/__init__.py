"""Preparing a mesh that the program does not know: its control points, parts and openings."""
