"""Short clips and a check for OpenGL."""

from tests.support.short_clips import _models, empty_clip, gl, short_clip

__all__ = ["_models", "empty_clip", "gl", "short_clip"]
