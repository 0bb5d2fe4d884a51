"""The panels: each draws one part of the desk and returns what it becomes, and what it asks for."""
