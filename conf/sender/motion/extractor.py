"""From tracked landmarks to the motion that travels: pose apart, smoothed, against the neutral pose, in FAPU.

Strategy: the fifty control points leave here as displacements that mean the same on any face. Two need care. Lids: the
tracker's lid landmarks never meet, so the gap they keep when shut is taken off and shut is made exactly shut. Pupils:
they are measured from the corners of their own eye, so they say where the eyeball is turned and nothing else.
"""

from dataclasses import astuple

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import (
    CONTROL_POINT_COUNT,
    CONTROL_POINT_INDEX,
    CONTROL_POINT_LANDMARKS,
    control_point_indices,
)
from conf.face.fapu import UNITS_PER_DISTANCE, Fapu
from conf.face.head_pose import HeadPose
from conf.protocol.messages import MotionFrame
from conf.sender.motion import eye_openness as lids
from conf.sender.motion.eye_openness import EyeOpennessEstimator
from conf.sender.motion.neutral_pose import NeutralPoseEstimator
from conf.sender.motion.one_euro_filter import OneEuroFilter
from conf.sender.tracking.canonical_face import CanonicalFace
from conf.sender.tracking.pose_removal import remove_head_pose
from conf.sender.tracking.tracker import TrackedFace


class MotionExtractor:
    """Turns the trackings of one person, in order of time, into motion."""

    def __init__(self, canonical: CanonicalFace, size: tuple[int, int], /) -> None:
        """Start with a mean face as neutral pose.

        size : width and height of the pictures, px
        """
        self._canonical = canonical
        self._size = size
        self._neutral = NeutralPoseEstimator()
        self._lids = EyeOpennessEstimator()
        self._points_filter = OneEuroFilter(min_cutoff=_MIN_CUTOFF, beta=_BETA)
        self._pose_filter = OneEuroFilter(min_cutoff=_POSE_MIN_CUTOFF, beta=_POSE_BETA)
        self._points: NDArray[np.float64] | None = None
        self._take_next = False

    @property
    def fapu(self) -> Fapu:
        """Return the units of this person's neutral face, in cm."""
        return Fapu.measure(self._neutral.points, closed_lid_gap=float(self._lids.closed_gap_ratio.mean()))

    @property
    def neutral_points(self) -> NDArray[np.float64]:
        """The (n, 3) control points of the neutral pose in use, cm in face axes."""
        return self._neutral.points

    @property
    def calibrated(self) -> bool:
        """Whether the neutral pose is this person's own."""
        return self._neutral.known

    def fapu_distances(self) -> tuple[float, ...]:
        """Return the five FAPU distances in cm, as they travel in the stream's parameters."""
        return astuple(self.fapu)

    def restart(self) -> None:
        """Begin a new row of timestamps, keeping what is known of the neutral pose."""
        self._points_filter.reset()
        self._pose_filter.reset()
        self._neutral.reset_clock()

    def set_neutral_now(self) -> None:
        """Take the face as it is now for the neutral pose; if there is none yet, as it will be in the next frame."""
        if self._points is None:
            self._take_next = True
        else:
            self._neutral.set(self._points)

    def update(self, tracking: TrackedFace, timestamp: float, /) -> MotionFrame:
        """Return the motion of a frame taken at `timestamp`, seconds."""
        aligned, pose = remove_head_pose(tracking.landmarks, self._canonical, self._size)
        smooth_pose = self._pose_filter.smooth(pose.to_vector(), timestamp)
        seen = aligned[CONTROL_POINT_LANDMARKS]
        self._points = self._points_filter.smooth(seen, timestamp)
        if self._take_next:
            self._take_next = False
            self._neutral.set(self._points)
        if tracking.blendshapes_age == 0:
            self._learn(seen, tracking.blendshapes, pose, timestamp)
        neutral = self._neutral.blended(timestamp)
        openness = self._lids.openness(self._points, neutral)
        displacements = to_displacements(self._points, neutral, self.fapu, openness)
        return MotionFrame(timestamp, displacements.astype(np.float32), smooth_pose)

    def _learn(
        self, points: NDArray[np.float64], blendshapes: NDArray[np.float32], pose: HeadPose, timestamp: float
    ) -> None:
        self._neutral.update(points, blendshapes, turn=off_axis_angle(pose), timestamp=timestamp)
        self._lids.update(points, self._neutral.points, blendshapes)


def off_axis_angle(pose: HeadPose, /) -> float:
    """Return the angle in radians between the nose and the camera."""
    return float(np.arccos(np.clip(pose.matrix()[2, 2], -1, 1)))


def to_displacements(
    points: NDArray[np.float64], neutral: NDArray[np.float64], fapu: Fapu, openness: NDArray[np.float64], /
) -> NDArray[np.float64]:
    """Return how far control points are from the neutral pose, (n, 3) in FAPU units.

    points, neutral : (n, 3) cm in face axes, of the same face
    openness : (2,) of the left and right eye: 0 brings the upper lid down onto the lower on any face
    """
    moved = points - neutral
    for pupil, corners in _EYES:
        moved[pupil] -= moved[corners].mean(axis=0)
        moved[pupil, 2] = 0.0
    units = moved / fapu.lengths()
    units[lids.UPPER, 1] = units[lids.LOWER, 1] + (openness - 1) * UNITS_PER_DISTANCE
    return units


_EYES = [
    (
        CONTROL_POINT_INDEX[f"pupil_{s}"],
        [CONTROL_POINT_INDEX[f"eye_inner_corner_{s}"], CONTROL_POINT_INDEX[f"eye_outer_corner_{s}"]],
    )
    for s in "lr"
]


def _per_point(usual: float, **by_name: float) -> NDArray[np.float64]:
    """Return (n, 1): a number for each control point, by the start of its name."""
    values = np.full((CONTROL_POINT_COUNT, 1), usual)
    for name, value in by_name.items():
        values[control_point_indices(name)] = value
    return values


# The filters' cutoffs in Hz, and betas in Hz for each cm (radian, picture height, e-fold) a second. Chosen on clips:
# speech moves lips at 5 Hz and a blink lasts 0.2 s, and both get through nearly whole; of a still face's jitter, 0.2 mm
# at 320x240, half is left.
_MIN_CUTOFF = _per_point(2.0, inner_lip=5.0, outer_lip=5.0, cupids_bow=5.0, eyelid=6.0, pupil=4.0)
_BETA = _per_point(3.0, inner_lip=6.0, outer_lip=6.0, cupids_bow=6.0, eyelid=20.0, pupil=6.0)
_POSE_MIN_CUTOFF = np.array([1.4, 1.4, 1.4, 2.8, 2.8, 1.4])
_POSE_BETA = np.array([120.0, 120.0, 120.0, 360.0, 360.0, 120.0])
