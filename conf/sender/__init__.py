"""The sending program: capture, tracking, motion, portrait. For other programs: from a clip to motion."""

from typing import TYPE_CHECKING

from conf.lazy import lazy_attributes

_SOURCES = {
    "MotionExtractor": "motion.extractor",
    "load_canonical_face": "tracking.canonical_face",
    "track_clip": "tracking.offline",
}

if TYPE_CHECKING:
    from conf.sender.motion.extractor import MotionExtractor as MotionExtractor
    from conf.sender.tracking.canonical_face import load_canonical_face as load_canonical_face
    from conf.sender.tracking.offline import track_clip as track_clip
else:
    __getattr__ = lazy_attributes(__name__, _SOURCES)

__all__ = list(_SOURCES)
