"""Draw a participant's portrait: a photo that the fifty control points move, with patches for mouth and eyes."""
