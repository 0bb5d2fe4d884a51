"""Prepare an unknown mesh: its control points, rigid parts, openings and texture."""
