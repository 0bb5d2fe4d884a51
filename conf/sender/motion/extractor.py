"""From tracked landmarks to motion for sending: head pose removed, smoothed, relative to the neutral pose, in FAPU.

Strategy: the fifty control points become displacements that mean the same on any face. Four need care. Lids: the
tracker's lid landmarks never meet, so the gap of the shut eye is subtracted, and a shut eye is exactly shut. Lips
likewise. Pupils: they are measured relative to the corners of their eye, so they show the rotation of the eyeball only.
Brows: see brow_reference.py. What the way to the drawing takes of small movements is added: see pre_emphasis.py.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, EYE_CORNERS, PUPILS, control_point_indices
from conf.face.deformation.constraints.lip_contact import send_lips_shut
from conf.face.fapu import UNITS_PER_DISTANCE, Fapu
from conf.face.head_pose import HeadPose
from conf.protocol.messages import MotionFrame
from conf.sender.motion.brow_reference import points_with_brows_from_bridge
from conf.sender.motion.eye_openness import LOWER, UPPER, EyeOpennessEstimator
from conf.sender.motion.neutral_pose import NeutralPoseEstimator
from conf.sender.motion.one_euro_filter import OneEuroFilter
from conf.sender.motion.pre_emphasis import emphasise, emphasise_openness
from conf.sender.tracking.canonical_face import CanonicalFace, remove_head_pose
from conf.sender.tracking.tracker import TrackedFace


class MotionExtractor:
    """Turns the tracked faces of one person, in order of time, into motion."""

    def __init__(
        self, canonical: CanonicalFace, size: tuple[int, int], /, *, neutral: NeutralPoseEstimator | None = None
    ) -> None:
        """Start with the mean face as neutral pose.

        size : width and height of the images, px
        neutral : estimator to use, None for a new one
        """
        self._canonical = canonical
        self._size = size
        self._neutral = NeutralPoseEstimator() if neutral is None else neutral
        self._eyes = EyeOpennessEstimator()
        self._points_filter = OneEuroFilter(min_cutoff=_MIN_CUTOFF, beta=_BETA)
        self._pose_filter = OneEuroFilter(min_cutoff=_POSE_MIN_CUTOFF, beta=_POSE_BETA)
        self._points: NDArray[np.float64] | None = None
        self._set_neutral_next = False
        self._fapu = self._measure_fapu()

    @property
    def fapu(self) -> Fapu:
        """The FAPU distances of this person's neutral face, cm."""
        return self._fapu

    @property
    def neutral_points(self) -> NDArray[np.float64]:
        """The control points (n, 3) of the neutral pose in use, cm in face axes."""
        return self._neutral.points

    @property
    def calibrated(self) -> bool:
        """Whether the neutral pose is this person's own."""
        return self._neutral.known

    def restart(self) -> None:
        """Start new timestamps and keep the neutral pose."""
        self._points_filter.reset()
        self._pose_filter.reset()
        self._neutral.reset_clock()

    def set_neutral_now(self) -> None:
        """Use the last face as the neutral pose; before the first face, use that."""
        if self._points is None:
            self._set_neutral_next = True
        else:
            self._neutral.set(self._points)
            self._fapu = self._measure_fapu()

    def update(self, tracked: TrackedFace, timestamp: float, /) -> MotionFrame:
        """Return the motion of a frame captured at `timestamp`, seconds."""
        aligned, pose = remove_head_pose(tracked.landmarks, self._canonical, self._size)
        smooth_pose = self._pose_filter.smooth(pose.to_vector(), timestamp)
        raw_points = points_with_brows_from_bridge(aligned)
        self._points = self._points_filter.smooth(raw_points, timestamp)
        if self._set_neutral_next:
            self._set_neutral_next = False
            self._neutral.set(self._points)
        if tracked.blendshapes_age == 0:
            self._neutral.update(raw_points, tracked.blendshapes, turn=off_axis_angle(pose), timestamp=timestamp)
            self._eyes.update(raw_points, self._neutral.points, tracked.blendshapes)
        neutral = self._neutral.blended(timestamp)
        openness = self._eyes.openness(self._points, neutral)
        self._fapu = self._measure_fapu()
        displacements = to_displacements(self._points, neutral, self.fapu, openness)
        return MotionFrame(timestamp, displacements.astype(np.float32), smooth_pose)

    def _measure_fapu(self) -> Fapu:
        return Fapu.measure(self._neutral.points, closed_lid_gap=float(self._eyes.closed_gap_ratio.mean()))


def off_axis_angle(pose: HeadPose, /) -> float:
    """Return the angle between the head's direction and the camera, radians."""
    return float(np.arccos(np.clip(pose.matrix()[2, 2], -1, 1)))


def to_displacements(
    points: NDArray[np.float64], neutral: NDArray[np.float64], fapu: Fapu, openness: NDArray[np.float64], /
) -> NDArray[np.float64]:
    """Return the displacements of control points from the neutral pose, (n, 3) in FAPU units.

    points, neutral : (n, 3) cm in face axes, of the same face
    openness : (2,) of the left and right eye: at 0 the upper lid touches the lower one on any face
    """
    moved = send_lips_shut(points - neutral)
    for pupil, corners in zip(PUPILS, EYE_CORNERS, strict=True):
        moved[pupil] -= moved[corners].mean(axis=0)
        moved[pupil, 2] = 0.0
    units = emphasise(moved / fapu.lengths())
    units[UPPER, 1] = units[LOWER, 1] + (emphasise_openness(openness) - 1) * UNITS_PER_DISTANCE
    return units


def _per_point(default: float, **by_prefix: float) -> NDArray[np.float64]:
    """Return (n, 1): a number for each control point, by the prefix of its name."""
    values = np.full((CONTROL_POINT_COUNT, 1), default)
    for prefix, value in by_prefix.items():
        values[control_point_indices(prefix)] = value
    return values


# Cutoffs in Hz, and betas in Hz per cm (radian, image height, e-fold) per second. Chosen on clips: speech moves lips at
# 5 Hz, a blink lasts 0.2 s, and both pass nearly unchanged; of a still face's jitter, 0.2 mm at 320x240, half is left.
_MIN_CUTOFF = _per_point(2.0, brow=3.0, inner_lip=5.0, outer_lip=5.0, cupids_bow=5.0, eyelid=6.0, pupil=4.0)
_BETA = _per_point(3.0, inner_lip=6.0, outer_lip=6.0, cupids_bow=6.0, eyelid=20.0, pupil=6.0)
_POSE_MIN_CUTOFF = np.array([1.4, 1.4, 1.4, 2.8, 2.8, 1.4])
_POSE_BETA = np.array([120.0, 120.0, 120.0, 360.0, 360.0, 120.0])
