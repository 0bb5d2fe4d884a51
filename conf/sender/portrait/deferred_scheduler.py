"""A portrait scheduler that is made when the first frame comes: a call without a portrait never imports what it needs.

That is SciPy and Pillow, which take a third of the time from a call's command to its first image.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from conf.protocol.messages import MotionFrame
from conf.protocol.portrait.object_sender import ObjectSender
from conf.sender.portrait.captured_face import CapturedFace
from conf.sender.tracking.canonical_face import CanonicalFace

if TYPE_CHECKING:
    from conf.sender.portrait.scheduler import PortraitScheduler


def import_portraits() -> None:
    """Import what makes portraits, so that no frame has to wait for it later."""
    import_module("conf.sender.portrait.scheduler")


class DeferredPortraitScheduler:
    """Passes frames to a PortraitScheduler."""

    def __init__(self, canonical: CanonicalFace, objects: ObjectSender) -> None:
        self._canonical = canonical
        self._objects = objects
        self._scheduler: PortraitScheduler | None = None

    def process_frame(self, face: CapturedFace, motion: MotionFrame, presence: float, now: float) -> None:
        """Process a frame as PortraitScheduler does."""
        if self._scheduler is None:
            from conf.sender.portrait.scheduler import PortraitScheduler

            self._scheduler = PortraitScheduler(self._canonical, self._objects)
        self._scheduler.process_frame(face, motion, presence, now)
