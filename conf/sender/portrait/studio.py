"""The sender's side of a portrait, frame by frame: when to take a photograph, when to add a patch, what to tell.

Strategy: a call should not begin without a face, so the best frame of the first moments is taken, whatever it is. A
clearly better one replaces it soon after, one in a new light or pose later, never often: a photograph costs as much
as a minute of patches. Patches fill the budget that the photograph leaves.
"""

from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import LANDMARKS
from conf.face.head_pose import HeadPose
from conf.face.portrait.features import EYES, FEATURES, MOUTH
from conf.protocol.messages import MotionFrame
from conf.protocol.portrait.outbox import PortraitOutbox
from conf.protocol.portrait.patch import MAX_SLOTS
from conf.protocol.portrait.photograph import NeutralUpdate, Photograph
from conf.protocol.portrait.things import encode_thing
from conf.protocol.token_bucket import TokenBucket
from conf.sender.canonical_face import CanonicalFace
from conf.sender.portrait.choice import judge, sharpness
from conf.sender.portrait.patchwork import PatchBudget, Patchwork, cut_patch, make_patch, match_light
from conf.sender.portrait.photographer import Shot, take_photograph

FIRST_LOOK_S = 0.4  # how long the first photograph is looked for
GOOD = 0.5  # marks: a frame this good is taken at once
MUCH_BETTER = 1.0  # marks: a frame this much better than the photograph replaces it
BETWEEN_S = 45.0  # between photographs
NEUTRAL_DRIFT_CM = 0.06  # the neutral pose is told again when a point has moved so far
NEUTRAL_EVERY_S = 1.0
WAITING_BYTES = 700  # no new patch while more than this is on its way
PATCH_BYTES_A_SECOND = 130  # in the long run, however much the face does
PATCH_BYTES_AT_ONCE = 2000
PRESENT = 0.8  # the tracker must be this sure
PATCHABLE_TURN = np.radians(25)  # a patch from a head turned farther against the photograph would not fit

BUDGETS = {MOUTH.name: PatchBudget(260, 14, 8.0), EYES.name: PatchBudget(330, 12, 8.0)}
PHOTO_SLOT, NEUTRAL_SLOT, PATCH_SLOTS = 0, 1, 2  # of the outbox
PHOTO_URGENCY, NEUTRAL_URGENCY, PATCH_URGENCY = 0, 1, 2


@dataclass(frozen=True)
class _Candidate:
    shot: Shot
    motion: MotionFrame
    marks: float


@dataclass(frozen=True)
class _Hanging:
    """The photograph that the receiver has or will have."""

    photo: Photograph
    pixels: NDArray[np.uint8]
    landmarks: NDArray[np.float64]  # (478, 2) 0 to 1
    marks: float
    taken_at: float


class PortraitStudio:
    """Watches the frames of one person and fills an outbox."""

    def __init__(self, canonical: CanonicalFace, outbox: PortraitOutbox) -> None:
        self._canonical = canonical
        self._outbox = outbox
        self._began: float | None = None
        self._best: _Candidate | None = None
        self._hanging: _Hanging | None = None
        self._works: list[Patchwork] = []
        self._told: tuple[NDArray[np.float64], float] = (np.zeros((0, 3)), float("-inf"))
        self._number = 0
        self._allowance = TokenBucket(PATCH_BYTES_A_SECOND, PATCH_BYTES_AT_ONCE)

    def watch(self, shot: Shot, motion: MotionFrame, presence: float, now: float) -> None:
        """Look at a frame.

        shot : the frame, its landmarks and the neutral pose in use
        presence : how sure the tracker is; now : seconds
        """
        if presence < PRESENT:
            return
        if self._began is None:
            self._began = now
        marks = judge(motion).marks - 0.1 * float(np.log1p(sharpness(shot.pixels, shot.landmarks)))
        if self._best is None or marks < self._best.marks:
            self._best = _Candidate(Shot(shot.pixels.copy(), shot.landmarks, shot.neutral, shot.fapu), motion, marks)
        if self._due(now):
            self._hang(now)
        if self._hanging is not None:
            self._tell_neutral(shot, now)
            self._patch(shot, motion, now)

    def _due(self, now: float) -> bool:
        """Whether it is time to send the best frame seen as a photograph."""
        assert self._best is not None and self._began is not None
        if self._hanging is None:
            return self._best.marks < GOOD or now - self._began >= FIRST_LOOK_S
        rested = now - self._hanging.taken_at >= BETWEEN_S
        return rested and self._best.marks < self._hanging.marks - MUCH_BETTER

    def _hang(self, now: float) -> None:
        best, self._best = self._best, None
        assert best is not None
        shot = best.shot
        photo = take_photograph(shot, self._canonical, self._number)
        self._number = (self._number + 1) % 256
        size = np.array(shot.pixels.shape[1::-1])
        self._hanging = _Hanging(photo, shot.pixels, shot.landmarks[:, :2] / size, best.marks, now)
        self._works = [Patchwork(f, BUDGETS[f.name], f.key(best.motion.displacements)) for f in FEATURES]
        for slot in range(len(FEATURES) * MAX_SLOTS):
            self._outbox.drop(PATCH_SLOTS + slot)
        self._outbox.drop(NEUTRAL_SLOT)
        self._told = (shot.neutral, now)
        self._outbox.put(PHOTO_SLOT, encode_thing(photo), urgency=PHOTO_URGENCY)

    def _tell_neutral(self, shot: Shot, now: float) -> None:
        told, at = self._told
        drift = float(np.abs(shot.neutral - told).max())
        if drift < NEUTRAL_DRIFT_CM or now - at < NEUTRAL_EVERY_S or self._hanging is None:
            return
        self._told = (shot.neutral.copy(), now)
        update = NeutralUpdate(self._hanging.photo.number, shot.neutral, astuple(shot.fapu))
        self._outbox.put(NEUTRAL_SLOT, encode_thing(update), urgency=NEUTRAL_URGENCY)

    def _patch(self, shot: Shot, motion: MotionFrame, now: float) -> None:
        hanging = self._hanging
        if hanging is None or self._outbox.waiting_bytes > WAITING_BYTES:
            return
        pose = HeadPose.from_vector(motion.pose)
        ahead = HeadPose.from_vector(hanging.photo.pose).matrix()[2] @ pose.matrix()[2]
        if np.arccos(np.clip(ahead, -1, 1)) > PATCHABLE_TURN:
            return
        keys = [feature.key(motion.displacements) for feature in FEATURES]
        region = max(range(len(FEATURES)), key=lambda r: self._works[r].novelty(keys[r]))
        feature, work, key = FEATURES[region], self._works[region], keys[region]
        budget = BUDGETS[feature.name]
        if work.novelty(key) < 1 or not self._allowance.take(budget.size, now):
            return
        centimetre = float(np.exp(pose.log_scale)) * len(shot.pixels)
        pixels, points = cut_patch(shot.pixels, shot.landmarks, feature, centimetre=centimetre)
        photo_points = hanging.landmarks[LANDMARKS[list(feature.points)]]
        pixels = match_light(pixels, points, hanging.pixels, photo_points)
        slot = work.take(key)
        patch = make_patch(pixels, points, key, where=(hanging.photo.number, region, slot), budget=budget.size)
        self._outbox.put(PATCH_SLOTS + region * MAX_SLOTS + slot, encode_thing(patch), urgency=PATCH_URGENCY)
