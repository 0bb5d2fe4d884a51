"""Show the caller: a photograph that the fifty points move, with patches for mouth and eyes."""
