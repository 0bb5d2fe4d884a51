"""The sender's side of a portrait: for each frame, what is put into the object sender.

A photo is selected (`photo_selection`), built in steps (`photo_builder`) and encoded once. From these bytes the
reference is decoded, as the receiver will decode it. Patches (`patch_scheduler`) use the bandwidth that photos leave.
"""

from collections.abc import Iterator
from dataclasses import astuple

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.patch_features import FEATURES
from conf.protocol.messages import MotionFrame
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.portrait.objects import encode_object
from conf.protocol.portrait.patch import MAX_SLOTS
from conf.protocol.portrait.photo import MIN_LOG_SCALE, NeutralPoseUpdate, Photo
from conf.protocol.portrait.view import MAX_VIEWS, View
from conf.sender.portrait.album import Album, view_steps
from conf.sender.portrait.background_learning import BackgroundLearner
from conf.sender.portrait.captured_face import CapturedFace
from conf.sender.portrait.patch_extraction import make_patch
from conf.sender.portrait.patch_scheduler import PATCH_BYTES, PatchScheduler, RateSharing
from conf.sender.portrait.photo_builder import DRAFT, FULL, PhotoBuilder
from conf.sender.portrait.photo_quality import image_penalty
from conf.sender.portrait.photo_selection import Candidate, PhotoSelector
from conf.sender.portrait.recent_frames import RecentFrames, evenly_spaced
from conf.sender.portrait.reference_photo import ReferencePhoto, patch_residual
from conf.sender.tracking.canonical_face import CanonicalFace

NEUTRAL_DRIFT_CM = 0.06  # movement of any neutral point after which the neutral pose is sent again
NEUTRAL_INTERVAL_S = 1.0
MIN_PRESENCE = 0.8  # of the tracked face, 0 to 1
MIN_SMOOTHED_LOG_SCALE = MIN_LOG_SCALE + 0.1  # of the motion's pose; a photo's own pose is not smoothed

PHOTO_SLOT, NEUTRAL_SLOT, PATCH_SLOTS = 0, 1, 2  # of the object sender
VIEW_SLOTS = PATCH_SLOTS + len(FEATURES) * MAX_SLOTS
BACKGROUND_SLOT = VIEW_SLOTS + MAX_VIEWS
# A view has the bytes of eight patches: those requested before it come first, then it has most of the rate.
PHOTO_PRIORITY, NEUTRAL_PRIORITY, PATCH_PRIORITY, VIEW_PRIORITY = range(4)
VIEW_INTERVAL_S = 1.0  # between choices of a view
REJECTED_INTERVAL_S = 3.0  # after a view that gained too little
BACKGROUND_SAMPLE_S = 0.3  # between frames that the background is learned from; 3 ms each
BACKGROUND_LEAD_S = 2.5  # from the photo to the first background: then it arrives with the photo, before the views
BACKGROUND_INTERVAL_S = 20.0  # between backgrounds
# Bytes not acknowledged yet with which the next photo or view is chosen: it is built while they are sent.
PHOTO_LEAD_BYTES = 700  # of the photo in use
VIEW_LEAD_BYTES = 900  # of photo and views


class PortraitScheduler:
    """Processes the frames of one person and fills an object sender."""

    def __init__(self, canonical: CanonicalFace, objects: ObjectSender) -> None:
        self._canonical = canonical
        self._objects = objects
        self._selector = PhotoSelector()
        self._recent = RecentFrames(FULL.max_height)
        self._album: Album | None = None  # of the photo in use, unless that is a draft
        self._view: Iterator[View | None] | None = None  # being built
        self._view_due = 0.0
        self._background: BackgroundLearner | None = None  # of the photo in use, unless that is a draft
        self._background_sample_due = self._background_due = 0.0
        self._sharing = RateSharing()
        self._patches = PatchScheduler()
        self._building: tuple[Candidate, PhotoBuilder] | None = None
        self._built: Photo | None = None  # waits for the one before to arrive
        self._photo_number = 0
        self._reference: ReferencePhoto | None = None
        self._last_neutral: tuple[NDArray[np.float64], float] = (np.zeros((0, 3)), float("-inf"))

    def process_frame(self, face: CapturedFace, motion: MotionFrame, presence: float, now: float) -> None:
        """Process a frame. A face too small for a photo is ignored.

        presence : 0 to 1, confidence of the tracker; now : seconds
        """
        if self._building is not None:
            candidate, builder = self._building
            self._built = self._built or builder.advance()
            if self._built is not None and self._objects.waiting_bytes_before(NEUTRAL_PRIORITY) == 0:
                built, self._built, self._building = self._built, None, None
                self._send_photo(built, candidate, now)
        if presence < MIN_PRESENCE or motion.pose[5] < MIN_SMOOTHED_LOG_SCALE:
            return
        if self._reference is not None:
            self._reference.scene.sample(face.pixels, motion, now)
            self._selector.set_scene_changed(now, changed=self._reference.scene.changed)
        penalty = self._selector.add_frame(face, motion, image_penalty(face.pixels, face.landmarks), now)
        self._recent.sample(face, motion, penalty, now)
        if self._building is None:
            self._start_photo(now)
        if self._reference is not None:
            self._send_neutral(self._reference, face, now)
            self._send_patch(self._reference, now)
            self._send_background(now)
            self._send_view(self._reference, now)

    def _start_photo(self, now: float) -> None:
        arrived = self._objects.waiting_bytes_before(NEUTRAL_PRIORITY) <= PHOTO_LEAD_BYTES
        best = self._selector.pop_due(now, delivered=arrived)
        if best is None:
            return
        is_draft = self._reference is None
        recent = [] if is_draft else evenly_spaced(self._recent.like(best.fixed_penalty))
        quality = DRAFT if is_draft else FULL
        builder = PhotoBuilder(best.face, self._canonical, self._photo_number, quality, recent=recent)
        self._building = best, builder
        self._photo_number = (self._photo_number + 1) % 256

    def _send_photo(self, built: Photo, candidate: Candidate, now: float) -> None:
        """Send a photo in place of the one before, whose patches and neutral pose are cancelled."""
        data = encode_object(built)
        is_draft, self._album, self._view, self._background = self._reference is None, None, None, None
        self._reference = ReferencePhoto.from_bytes(data, candidate.face)
        self._selector.set_photo(candidate, now)
        self._patches.set_photo(candidate.motion.displacements)
        self._last_neutral = (candidate.face.neutral, now)
        if not is_draft:
            self._album = Album(self._reference.warp, self._reference.pixels)
            self._background = BackgroundLearner(self._reference.warp, self._reference.pixels, built.number)
            self._background_due = now + BACKGROUND_LEAD_S
        for slot in range(NEUTRAL_SLOT, BACKGROUND_SLOT + 1):
            self._objects.cancel(slot)
        self._objects.send_object(PHOTO_SLOT, data, priority=PHOTO_PRIORITY)

    def _send_neutral(self, reference: ReferencePhoto, face: CapturedFace, now: float) -> None:
        reported, reported_at = self._last_neutral
        if np.abs(face.neutral - reported).max() < NEUTRAL_DRIFT_CM or now - reported_at < NEUTRAL_INTERVAL_S:
            return
        self._last_neutral = (face.neutral.copy(), now)
        reference.warp.set_neutral(face.neutral, face.fapu.lengths())
        update = NeutralPoseUpdate(reference.photo.number, face.neutral, astuple(face.fapu))
        self._objects.send_object(NEUTRAL_SLOT, encode_object(update), priority=NEUTRAL_PRIORITY)

    def _send_patch(self, reference: ReferencePhoto, now: float) -> None:
        before_views = self._objects.waiting_bytes_before(VIEW_PRIORITY)
        view_bytes = self._objects.waiting_bytes - before_views
        if not self._sharing.allows_patch(view_bytes):
            return
        frames = self._recent.all_and_last()
        below = self._album.shown_descriptors(frames) if self._album is not None else None
        request = self._patches.next_request(
            frames, now, waiting_bytes=before_views, can_patch=reference.can_patch, below=below
        )
        if request is None:
            return
        self._sharing.on_patch(view_bytes)
        region, slot, frame = request
        residual, points = patch_residual(reference, frame, FEATURES[region])
        target, max_bytes = (reference.photo.number, region, slot), PATCH_BYTES[FEATURES[region].name]
        patch = make_patch(residual, points, frame.descriptors[region], target=target, max_bytes=max_bytes)
        object_slot = PATCH_SLOTS + region * MAX_SLOTS + slot
        self._objects.send_object(object_slot, encode_object(patch), priority=PATCH_PRIORITY)

    def _send_background(self, now: float) -> None:
        """Learn the background behind the person, and send it when enough is known."""
        learner, frame = self._background, self._recent.last
        if learner is None or frame is None or now < self._background_sample_due:
            return
        self._background_sample_due = now + BACKGROUND_SAMPLE_S
        learner.sample(frame)
        if now >= self._background_due and learner.is_worth_sending:
            self._background_due = now + BACKGROUND_INTERVAL_S
            data = encode_object(learner.build())
            self._objects.send_object(BACKGROUND_SLOT, data, priority=VIEW_PRIORITY)

    def _send_view(self, reference: ReferencePhoto, now: float) -> None:
        """Build a view, a step in each frame, once nearly all of the photo and of the views before has arrived."""
        if self._view is not None:
            view = next(self._view)
            if view is not None:
                self._view = None
                if self._album is None or not self._album.add(view):
                    self._view_due = now + REJECTED_INTERVAL_S
                    return
                self._objects.send_object(VIEW_SLOTS + view.slot, encode_object(view), priority=VIEW_PRIORITY)
            return
        if self._album is None:
            return
        self._album.describe(self._recent.clear_ones(), is_covered=reference.is_covered)
        if self._building is not None or now < self._view_due:
            return
        if self._photo_and_view_bytes() > VIEW_LEAD_BYTES:
            return
        self._view_due = now + VIEW_INTERVAL_S
        choice = self._album.choose()
        if choice is not None:
            self._view = view_steps(choice, reference.warp, reference.photo.number)

    def _photo_and_view_bytes(self) -> int:
        """Return the bytes of photo and views that have not been acknowledged."""
        before_views = self._objects.waiting_bytes_before(VIEW_PRIORITY)
        photo = self._objects.waiting_bytes_before(NEUTRAL_PRIORITY)
        return photo + self._objects.waiting_bytes - before_views
