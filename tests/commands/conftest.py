"""Short clips."""

from tests.support.short_clips import empty_clip, short_clip

__all__ = ["empty_clip", "short_clip"]
