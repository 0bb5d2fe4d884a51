"""A small head without files, and OpenGL when there is some."""

from tests.support.stand_in_head import face, overlay, window

__all__ = ["face", "overlay", "window"]
