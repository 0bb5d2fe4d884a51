"""The sender's side of a portrait, frame by frame: when to take a photograph, when to add a patch, what to tell.

Strategy: a call should not begin without a face, so the best frame of the first moments is taken, whatever it is, and
sent as a draft of few bytes. When it is there the best frame since takes its place in full. A better one replaces that,
the sooner the better it is, never often: a photograph costs as much as a minute of patches. When light or place have
changed for good, a new one is due though it be no better. Patches fill the budget that the photograph leaves.
"""

from collections.abc import Iterator
from dataclasses import astuple, dataclass, replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.patch_features import EYES, FEATURES, MOUTH
from conf.protocol.messages import MotionFrame
from conf.protocol.portrait.object_sender import PortraitOutbox
from conf.protocol.portrait.objects import encode_thing
from conf.protocol.portrait.patch import MAX_SLOTS
from conf.protocol.portrait.photo import (
    LEAST_LOG_SCALE,
    NeutralUpdate,
    Photograph,
    decode_photograph,
    encode_photograph,
)
from conf.protocol.rate_limit import TokenBucket
from conf.sender.portrait.patch_selection import PatchBudget, Patchwork, make_patch
from conf.sender.portrait.photo_builder import DRAFT, FULL, Shot, develop
from conf.sender.portrait.photo_quality import Habit, haste, judge, judge_picture
from conf.sender.portrait.reference_photo import Hanging, differ
from conf.sender.tracking.canonical_face import CanonicalFace

DRAFT_STEPS = 3  # of developing a draft that a frame's time has room for
FIRST_LOOK_S = 0.3  # how long the first photograph is looked for
GOOD = 2.0  # marks beyond those of the clearest picture seen: a frame this good is taken at once
DECENT = 2.2  # the same: worse than this the photograph after the draft should not be
UNBEATEN_S = 0.5  # a frame must be the best for so long: a hand that goes away takes a moment
DRAFT_LASTS_S = 10.0  # but by then it is taken
BETWEEN_S = 45.0  # between photographs, for one mark of improvement; for two, half of it
BETWEEN_VIEWS_S = 15.0  # between photographs of other light or place: all of the usual budget
LOOK_S = 1.5  # how long a photograph of other light or place is looked for
PATIENCE = 0.2  # marks a second: by so much worse the photograph may be that takes a draft's or an old view's place
NEUTRAL_DRIFT_CM = 0.06  # the neutral pose is told again when a point has moved so far
NEUTRAL_EVERY_S = 1.0
WAITING_BYTES = 700  # no new patch while more than this is on its way
PATCH_BYTES_A_SECOND = 115  # in the long run, however much the face does
PATCH_BYTES_AT_ONCE = 1600
PRESENT = 0.8  # the tracker must be this sure
FARTHEST = LEAST_LOG_SCALE + 0.1  # of the head's logarithmic scale: the picture's own pose is not smoothed as this is

BUDGETS = {MOUTH.name: PatchBudget(150, 16, 6.0), EYES.name: PatchBudget(180, 16, 6.0)}
PHOTO_SLOT, NEUTRAL_SLOT, PATCH_SLOTS = 0, 1, 2  # of the outbox
PHOTO_URGENCY, NEUTRAL_URGENCY, PATCH_URGENCY = 0, 1, 2


@dataclass(frozen=True)
class _Candidate:
    shot: Shot
    motion: MotionFrame
    moment: float  # marks of its pixels and of haste
    at: float

    def marks(self, habit: Habit) -> float:
        return judge(self.motion, habit).marks + self.moment


@dataclass(frozen=True)
class _Developing:
    candidate: _Candidate
    steps: Iterator[Photograph | None]
    draft: bool


class PortraitStudio:
    """Watches the frames of one person and fills an outbox."""

    def __init__(self, canonical: CanonicalFace, outbox: PortraitOutbox) -> None:
        self._canonical = canonical
        self._outbox = outbox
        self._began: float | None = None
        self._habit = Habit()
        self._before: MotionFrame | None = None
        self._best: _Candidate | None = None
        self._developing: _Developing | None = None
        self._hanging: Hanging | None = None
        self._shown: _Candidate | None = None  # of which the photograph was made
        self._is_draft = False
        self._clearest = float("inf")  # marks of the best picture seen, whatever the face in it did
        self._changed_at: float | None = None  # when light or place were found to have changed
        self._works: list[Patchwork] = []
        self._told: tuple[NDArray[np.float64], float] = (np.zeros((0, 3)), float("-inf"))
        self._number = 0
        self._allowance = TokenBucket(PATCH_BYTES_A_SECOND, PATCH_BYTES_AT_ONCE)

    def watch(self, shot: Shot, motion: MotionFrame, presence: float, now: float) -> None:
        """Look at a frame.

        shot : the frame, its landmarks and the neutral pose in use
        presence : how sure the tracker is; now : seconds
        A face too far away for a photograph is not looked at.
        """
        if self._developing is not None:
            self._develop(self._developing, now)
        if presence < PRESENT or motion.pose[5] < FARTHEST:
            return
        if self._hanging is not None:
            self._look(self._hanging, shot, motion, now)
        self._judge(shot, motion, now)
        if self._hanging is not None:
            self._tell_neutral(self._hanging, shot, now)
            self._patch(self._hanging, shot, motion, now)

    def _look(self, hanging: Hanging, shot: Shot, motion: MotionFrame, now: float) -> None:
        """Notice that the camera sees another view than the photograph shows."""
        hanging.view.look(shot.pixels, motion, now)
        if not hanging.view.changed:
            self._changed_at = None
        elif self._changed_at is None:
            self._changed_at, self._best = now, None

    def _judge(self, shot: Shot, motion: MotionFrame, now: float) -> None:
        """Keep the best frame since the last photograph, and have it developed when it is time."""
        if self._began is None:
            self._began = now
        picture = judge_picture(shot.pixels, shot.landmarks)
        self._clearest = min(self._clearest, picture)
        self._habit.look(motion, now)
        candidate = _Candidate(shot, motion, picture + haste(self._before or motion, motion), now)
        self._before = motion
        if self._best is None or candidate.marks(self._habit) < self._best.marks(self._habit):
            self._best = replace(candidate, shot=replace(shot, pixels=shot.pixels.copy()))
        if self._developing is None and self._due(self._best, now, now - self._began):
            draft = self._hanging is None
            steps = develop(self._best.shot, self._canonical, self._number, DRAFT if draft else FULL)
            self._developing = _Developing(self._best, steps, draft)
            self._number = (self._number + 1) % 256
            self._best = None

    def _due(self, best: _Candidate, now: float, elapsed: float) -> bool:
        """Whether it is time to send the best frame seen as a photograph."""
        hanging, shown, marks = self._hanging, self._shown, best.marks(self._habit)
        flaws = marks - self._clearest
        if hanging is None or shown is None:
            return flaws < GOOD or elapsed >= FIRST_LOOK_S
        if not self._outbox.delivered(PHOTO_SLOT) or now < best.at + UNBEATEN_S:
            return False
        better, age = shown.marks(self._habit) - marks, now - hanging.taken_at
        if self._is_draft:
            return better >= -PATIENCE * age and (flaws < DECENT or age >= DRAFT_LASTS_S)
        if self._changed_at is not None:
            looked = now - self._changed_at
            return age >= BETWEEN_VIEWS_S and looked >= LOOK_S and better >= -PATIENCE * looked
        return better >= 1 and age * better >= BETWEEN_S

    def _develop(self, developing: _Developing, now: float) -> None:
        """Go on with the photograph, faster with a draft; when it is done, it takes the place of the one before."""
        steps = islice(developing.steps, DRAFT_STEPS if developing.draft else 1)
        photo = next((photo for photo in steps if photo is not None), None)
        if photo is None:
            return
        candidate = developing.candidate
        self._is_draft, self._developing, self._changed_at = developing.draft, None, None
        self._hanging = Hanging.of(decode_photograph(encode_photograph(photo)), candidate.shot, now)
        self._shown = candidate
        self._works = [Patchwork(f, BUDGETS[f.name], f.key(candidate.motion.displacements)) for f in FEATURES]
        for slot in range(len(FEATURES) * MAX_SLOTS):
            self._outbox.drop(PATCH_SLOTS + slot)
        self._outbox.drop(NEUTRAL_SLOT)
        self._told = (candidate.shot.neutral, now)
        self._outbox.put(PHOTO_SLOT, encode_thing(self._hanging.photo), urgency=PHOTO_URGENCY)

    def _tell_neutral(self, hanging: Hanging, shot: Shot, now: float) -> None:
        told, at = self._told
        if float(np.abs(shot.neutral - told).max()) < NEUTRAL_DRIFT_CM or now - at < NEUTRAL_EVERY_S:
            return
        self._told = (shot.neutral.copy(), now)
        hanging.warp.follow_neutral(shot.neutral, shot.fapu.lengths())
        update = NeutralUpdate(hanging.photo.number, shot.neutral, astuple(shot.fapu))
        self._outbox.put(NEUTRAL_SLOT, encode_thing(update), urgency=NEUTRAL_URGENCY)

    def _patch(self, hanging: Hanging, shot: Shot, motion: MotionFrame, now: float) -> None:
        """Send a patch of the feature that does what no patch shows yet, if one does."""
        if self._outbox.waiting_bytes > WAITING_BYTES:
            return
        keys = [feature.key(motion.displacements) for feature in FEATURES]
        region = max(range(len(FEATURES)), key=lambda r: self._works[r].novelty(keys[r]))
        feature, work, key = FEATURES[region], self._works[region], keys[region]
        budget = BUDGETS[feature.name]
        if work.novelty(key) < 1 or not hanging.fits(shot, motion, region):
            return
        if not self._allowance.take(budget.size, now):
            return
        difference, points = differ(hanging, shot, motion, feature)
        slot = work.take(key)
        patch = make_patch(difference, points, key, where=(hanging.photo.number, region, slot), budget=budget.size)
        self._outbox.put(PATCH_SLOTS + region * MAX_SLOTS + slot, encode_thing(patch), urgency=PATCH_URGENCY)
