"""Decide when a photo is sent and which frame it shows. Pure: fed with penalties and times.

Strategy: a call should start with a face, so the first photo is the best frame of the first 0.3 s, whatever it is, as a
draft of few bytes. Once it has arrived, the best frame since then follows in full quality. A clearly better frame
replaces that, the sooner the better it is, but rarely: it takes half a minute of what motion leaves. When lighting or
position have changed persistently, a new photo is due even if it is no better.
"""

from dataclasses import dataclass

from conf.protocol.messages import MotionFrame
from conf.sender.portrait.captured_face import CapturedFace
from conf.sender.portrait.photo_quality import TypicalPose, motion_penalty, speed_penalty

FIRST_SEARCH_S = 0.3  # for the draft
ACCEPT_PENALTY = 2.0  # above the best image penalty so far: the draft is sent at once below this
REPLACE_PENALTY = 2.2  # the same, for the photo after the draft
MIN_LEAD_S = 0.5  # a frame must stay the best this long: a hand needs that to leave the face
MAX_DRAFT_S = 3.0  # after which the best frame replaces the draft, whatever its penalty
PHOTO_INTERVAL_S = 120.0  # between photos that differ by a penalty of 1; half of it for 2
SCENE_INTERVAL_S = 15.0  # between photos after a scene change: the whole usual budget
SCENE_SEARCH_S = 1.5  # for a photo after a scene change
PENALTY_DECAY = 0.2  # 1/s: a draft or an outdated photo counts as worse by this much each second


@dataclass(frozen=True)
class Candidate:
    """A frame that may become a photo.

    fixed_penalty : of its image and its speed; time : seconds
    """

    face: CapturedFace
    motion: MotionFrame
    fixed_penalty: float
    time: float

    def penalty(self, typical: TypicalPose) -> float:
        """Return the whole penalty; it changes with the typical pose."""
        return motion_penalty(self.motion, typical) + self.fixed_penalty


class PhotoSelector:
    """Keeps the best frame since the last photo and decides when it is due."""

    def __init__(self) -> None:
        self._typical = TypicalPose()
        self._start: float | None = None
        self._previous: MotionFrame | None = None
        self._best: Candidate | None = None
        self._min_image_penalty = float("inf")
        self._photo: Candidate | None = None  # the frame that the photo in use shows
        self._photo_time = 0.0
        self._is_draft = False
        self._scene_changed_at: float | None = None

    def add_frame(self, face: CapturedFace, motion: MotionFrame, image_penalty: float, now: float) -> float:
        """Keep a frame if it is the best since the last photo. Returns the penalty of its image and its speed."""
        if self._start is None:
            self._start = now
        self._min_image_penalty = min(self._min_image_penalty, image_penalty)
        self._typical.sample(motion, now)
        candidate = Candidate(face, motion, image_penalty + speed_penalty(self._previous or motion, motion), now)
        self._previous = motion
        if self._best is None or candidate.penalty(self._typical) < self._best.penalty(self._typical):
            self._best = candidate
        return candidate.fixed_penalty

    def set_scene_changed(self, now: float, *, changed: bool) -> None:
        """Note whether the scene differs from the photo's; frames from before a change are dropped."""
        if not changed:
            self._scene_changed_at = None
        elif self._scene_changed_at is None:
            self._scene_changed_at, self._best = now, None

    def pop_due(self, now: float, *, delivered: bool) -> Candidate | None:
        """Return the best frame, and drop it, if a photo of it is due.

        delivered : whether the photo in use has arrived
        """
        best = self._best
        if best is None or not self._is_due(best, now, delivered=delivered):
            return None
        self._best = None
        return best

    def set_photo(self, candidate: Candidate, now: float) -> None:
        """Note that a photo of this frame is in use from now on; the first is the draft."""
        self._is_draft = self._photo is None
        self._photo, self._photo_time, self._scene_changed_at = candidate, now, None

    def _is_due(self, best: Candidate, now: float, *, delivered: bool) -> bool:
        penalty = best.penalty(self._typical)
        excess = penalty - self._min_image_penalty
        if self._photo is None:
            return excess < ACCEPT_PENALTY or now - (self._start or 0.0) >= FIRST_SEARCH_S
        if not delivered or now < best.time + MIN_LEAD_S:
            return False
        gain, age = self._photo.penalty(self._typical) - penalty, now - self._photo_time
        if self._is_draft:
            return gain >= -PENALTY_DECAY * age and (excess < REPLACE_PENALTY or age >= MAX_DRAFT_S)
        if self._scene_changed_at is not None:
            search = now - self._scene_changed_at
            return age >= SCENE_INTERVAL_S and search >= SCENE_SEARCH_S and gain >= -PENALTY_DECAY * search
        return gain >= 1 and age * gain >= PHOTO_INTERVAL_S
