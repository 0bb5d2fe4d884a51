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
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.portrait.objects import encode_object
from conf.protocol.portrait.patch import MAX_SLOTS
from conf.protocol.portrait.photo import (
    MIN_LOG_SCALE,
    NeutralPoseUpdate,
    Photo,
    decode_photo,
    encode_photo,
)
from conf.protocol.rate_limit import TokenBucket
from conf.sender.portrait.patch_selection import PatchBudget, PatchSet, make_patch
from conf.sender.portrait.photo_builder import DRAFT, FULL, CapturedFace, build_photo_steps
from conf.sender.portrait.photo_quality import TypicalPose, image_penalty, motion_penalty, speed_penalty
from conf.sender.portrait.reference_photo import ReferencePhoto, patch_residual
from conf.sender.tracking.canonical_face import CanonicalFace

DRAFT_STEPS = 3  # of developing a draft that a frame's time has room for
FIRST_LOOK_S = 0.3  # how long the first photograph is looked for
ACCEPT_PENALTY = 2.0  # marks beyond those of the clearest picture seen: a frame this good is taken at once
REPLACE_PENALTY = 2.2  # the same: worse than this the photograph after the draft should not be
MIN_LEAD_S = 0.5  # a frame must be the best for so long: a hand that goes away takes a moment
DRAFT_LASTS_S = 10.0  # but by then it is taken
BETWEEN_S = 45.0  # between photographs, for one mark of improvement; for two, half of it
BETWEEN_VIEWS_S = 15.0  # between photographs of other light or place: all of the usual budget
LOOK_S = 1.5  # how long a photograph of other light or place is looked for
PENALTY_DECAY = (
    0.2  # marks a second: by so much worse the photograph may be that takes a draft's or an old view's place
)
NEUTRAL_DRIFT_CM = 0.06  # the neutral pose is told again when a point has moved so far
NEUTRAL_EVERY_S = 1.0
WAITING_BYTES = 700  # no new patch while more than this is on its way
PATCH_BYTES_A_SECOND = 115  # in the long run, however much the face does
PATCH_BYTES_AT_ONCE = 1600
MIN_PRESENCE = 0.8  # the tracker must be this sure
MIN_LOG_SCALE = (
    MIN_LOG_SCALE + 0.1
)  # of the head's logarithmic scale: the picture's own pose is not smoothed as this is

BUDGETS = {MOUTH.name: PatchBudget(150, 16, 6.0), EYES.name: PatchBudget(180, 16, 6.0)}
PHOTO_SLOT, NEUTRAL_SLOT, PATCH_SLOTS = 0, 1, 2  # of the outbox
PHOTO_URGENCY, NEUTRAL_URGENCY, PATCH_URGENCY = 0, 1, 2


@dataclass(frozen=True)
class _Candidate:
    shot: CapturedFace
    motion: MotionFrame
    moment: float  # marks of its pixels and of haste
    at: float

    def marks(self, habit: TypicalPose) -> float:
        return motion_penalty(self.motion, habit).penalty + self.moment


@dataclass(frozen=True)
class _PhotoInProgress:
    candidate: _Candidate
    steps: Iterator[Photo | None]
    draft: bool


class PortraitScheduler:
    """Watches the frames of one person and fills an outbox."""

    def __init__(self, canonical: CanonicalFace, outbox: ObjectSender) -> None:
        self._canonical = canonical
        self._outbox = outbox
        self._began: float | None = None
        self._typical = TypicalPose()
        self._before: MotionFrame | None = None
        self._best: _Candidate | None = None
        self._developing: _PhotoInProgress | None = None
        self._reference: ReferencePhoto | None = None
        self._shown: _Candidate | None = None  # of which the photograph was made
        self._is_draft = False
        self._clearest = float("inf")  # marks of the best picture seen, whatever the face in it did
        self._changed_at: float | None = None  # when light or place were found to have changed
        self._patch_sets: list[PatchSet] = []
        self._last_neutral: tuple[NDArray[np.float64], float] = (np.zeros((0, 3)), float("-inf"))
        self._number = 0
        self._allowance = TokenBucket(PATCH_BYTES_A_SECOND, PATCH_BYTES_AT_ONCE)

    def process_frame(self, shot: CapturedFace, motion: MotionFrame, presence: float, now: float) -> None:
        """Look at a frame.

        shot : the frame, its landmarks and the neutral pose in use
        presence : how sure the tracker is; now : seconds
        A face too far away for a photograph is not looked at.
        """
        if self._developing is not None:
            self._develop(self._developing, now)
        if presence < MIN_PRESENCE or motion.pose[5] < MIN_LOG_SCALE:
            return
        if self._reference is not None:
            self._look(self._reference, shot, motion, now)
        self._judge(shot, motion, now)
        if self._reference is not None:
            self._tell_neutral(self._reference, shot, now)
            self._patch(self._reference, shot, motion, now)

    def _look(self, hanging: ReferencePhoto, shot: CapturedFace, motion: MotionFrame, now: float) -> None:
        """Notice that the camera sees another view than the photograph shows."""
        hanging.view.sample(shot.pixels, motion, now)
        if not hanging.view.changed:
            self._changed_at = None
        elif self._changed_at is None:
            self._changed_at, self._best = now, None

    def _judge(self, shot: CapturedFace, motion: MotionFrame, now: float) -> None:
        """Keep the best frame since the last photograph, and have it developed when it is time."""
        if self._began is None:
            self._began = now
        picture = image_penalty(shot.pixels, shot.landmarks)
        self._clearest = min(self._clearest, picture)
        self._typical.sample(motion, now)
        candidate = _Candidate(shot, motion, picture + speed_penalty(self._before or motion, motion), now)
        self._before = motion
        if self._best is None or candidate.marks(self._typical) < self._best.marks(self._typical):
            self._best = replace(candidate, shot=replace(shot, pixels=shot.pixels.copy()))
        if self._developing is None and self._due(self._best, now, now - self._began):
            draft = self._reference is None
            steps = build_photo_steps(self._best.shot, self._canonical, self._number, DRAFT if draft else FULL)
            self._developing = _PhotoInProgress(self._best, steps, draft)
            self._number = (self._number + 1) % 256
            self._best = None

    def _due(self, best: _Candidate, now: float, elapsed: float) -> bool:
        """Whether it is time to send the best frame seen as a photograph."""
        hanging, shown, marks = self._reference, self._shown, best.marks(self._typical)
        flaws = marks - self._clearest
        if hanging is None or shown is None:
            return flaws < ACCEPT_PENALTY or elapsed >= FIRST_LOOK_S
        if not self._outbox.delivered(PHOTO_SLOT) or now < best.at + MIN_LEAD_S:
            return False
        better, age = shown.marks(self._typical) - marks, now - hanging.taken_at
        if self._is_draft:
            return better >= -PENALTY_DECAY * age and (flaws < REPLACE_PENALTY or age >= DRAFT_LASTS_S)
        if self._changed_at is not None:
            looked = now - self._changed_at
            return age >= BETWEEN_VIEWS_S and looked >= LOOK_S and better >= -PENALTY_DECAY * looked
        return better >= 1 and age * better >= BETWEEN_S

    def _develop(self, developing: _PhotoInProgress, now: float) -> None:
        """Go on with the photograph, faster with a draft; when it is done, it takes the place of the one before."""
        steps = islice(developing.steps, DRAFT_STEPS if developing.draft else 1)
        photo = next((photo for photo in steps if photo is not None), None)
        if photo is None:
            return
        candidate = developing.candidate
        self._is_draft, self._developing, self._changed_at = developing.draft, None, None
        self._reference = ReferencePhoto.create(decode_photo(encode_photo(photo)), candidate.shot, now)
        self._shown = candidate
        self._patch_sets = [
            PatchSet(f, BUDGETS[f.name], f.quantised_descriptor(candidate.motion.displacements)) for f in FEATURES
        ]
        for slot in range(len(FEATURES) * MAX_SLOTS):
            self._outbox.cancel(PATCH_SLOTS + slot)
        self._outbox.cancel(NEUTRAL_SLOT)
        self._last_neutral = (candidate.shot.neutral, now)
        self._outbox.send_object(PHOTO_SLOT, encode_object(self._reference.photo), priority=PHOTO_URGENCY)

    def _tell_neutral(self, hanging: ReferencePhoto, shot: CapturedFace, now: float) -> None:
        told, at = self._last_neutral
        if float(np.abs(shot.neutral - told).max()) < NEUTRAL_DRIFT_CM or now - at < NEUTRAL_EVERY_S:
            return
        self._last_neutral = (shot.neutral.copy(), now)
        hanging.warp.set_neutral(shot.neutral, shot.fapu.lengths())
        update = NeutralPoseUpdate(hanging.photo.number, shot.neutral, astuple(shot.fapu))
        self._outbox.send_object(NEUTRAL_SLOT, encode_object(update), priority=NEUTRAL_URGENCY)

    def _patch(self, hanging: ReferencePhoto, shot: CapturedFace, motion: MotionFrame, now: float) -> None:
        """Send a patch of the feature that does what no patch shows yet, if one does."""
        if self._outbox.waiting_bytes > WAITING_BYTES:
            return
        keys = [feature.quantised_descriptor(motion.displacements) for feature in FEATURES]
        region = max(range(len(FEATURES)), key=lambda r: self._patch_sets[r].novelty(keys[r]))
        feature, work, key = FEATURES[region], self._patch_sets[region], keys[region]
        budget = BUDGETS[feature.name]
        if work.novelty(key) < 1 or not hanging.can_patch(shot, motion, region):
            return
        if not self._allowance.take(budget.size, now):
            return
        difference, points = patch_residual(hanging, shot, motion, feature)
        slot = work.assign_slot(key)
        patch = make_patch(difference, points, key, target=(hanging.photo.number, region, slot), budget=budget.size)
        self._outbox.send_object(PATCH_SLOTS + region * MAX_SLOTS + slot, encode_object(patch), priority=PATCH_URGENCY)
