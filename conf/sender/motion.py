"""From tracked landmarks to the motion that travels: pose apart, smoothed, against the neutral pose, in FAPU.

Strategy: the fifty control points leave here as displacements that mean the same on any face. Two need care. Lids: the
tracker's lid landmarks never meet, so the gap they keep when shut is taken off and shut is made exactly shut. Pupils:
they are measured from the corners of their own eye, so they say where the eyeball is turned and nothing else.
"""

from dataclasses import astuple

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, INDEX, LANDMARKS, indices
from conf.face.fapu import UNITS_PER_DISTANCE, Fapu
from conf.face.head_pose import HeadPose
from conf.protocol.messages import MotionFrame
from conf.sender.calibration import NeutralPose
from conf.sender.canonical_face import CanonicalFace
from conf.sender.pose import remove_head_pose
from conf.sender.smoothing import OneEuroFilter
from conf.sender.tracker import Tracking

SHUT_LID_GAP = (
    0.12  # what is left between the lid landmarks of a shut eye, as a share of the open gap, seen on the clips
)


class MotionExtractor:
    """Turns the trackings of one person, in order of time, into motion."""

    def __init__(self, canonical: CanonicalFace, size: tuple[int, int], /) -> None:
        """Start with a mean face as neutral pose.

        size : width and height of the pictures, px
        """
        self._canonical = canonical
        self._size = size
        self._neutral = NeutralPose()
        self._points_filter = OneEuroFilter(min_cutoff=_MIN_CUTOFF, beta=_BETA)
        self._pose_filter = OneEuroFilter(min_cutoff=_POSE_MIN_CUTOFF, beta=_POSE_BETA)
        self._points: NDArray[np.float64] | None = None
        self._take_next = False

    @property
    def fapu(self) -> Fapu:
        """Return the units of this person's neutral face, in cm."""
        return Fapu.measure(self._neutral.points, closed_lid_gap=SHUT_LID_GAP)

    @property
    def calibrated(self) -> bool:
        """Whether the neutral pose is this person's own."""
        return self._neutral.known

    def fapu_lengths(self) -> tuple[float, ...]:
        """Return the five FAPU distances in cm, as they travel in the stream's parameters."""
        return astuple(self.fapu)

    def restart(self) -> None:
        """Begin a new row of timestamps, keeping what is known of the neutral pose."""
        self._points_filter.reset()
        self._pose_filter.reset()
        self._neutral.restart()

    def calibrate_now(self) -> None:
        """Take the face as it is now for the neutral pose; if there is none yet, as it will be in the next frame."""
        if self._points is None:
            self._take_next = True
        else:
            self._neutral.take(self._points)

    def update(self, tracking: Tracking, timestamp: float, /) -> MotionFrame:
        """Return the motion of a frame taken at `timestamp`, seconds."""
        aligned, pose = remove_head_pose(tracking.landmarks, self._canonical, self._size)
        smooth_pose = self._pose_filter.smooth(pose.to_vector(), timestamp)
        self._points = self._points_filter.smooth(aligned[LANDMARKS], timestamp)
        if self._take_next:
            self._take_next = False
            self._neutral.take(self._points)
        if tracking.blendshapes_age == 0:
            turn = turn_from_camera(pose)
            self._neutral.learn(self._points, tracking.blendshapes, turn=turn, timestamp=timestamp)
        neutral = self._neutral.at(timestamp)
        displacements = to_displacements(self._points, neutral, self.fapu)
        return MotionFrame(timestamp, displacements.astype(np.float32), smooth_pose)


def turn_from_camera(pose: HeadPose, /) -> float:
    """Return the angle in radians between the nose and the camera."""
    return float(np.arccos(np.clip(pose.matrix()[2, 2], -1, 1)))


def to_displacements(points: NDArray[np.float64], neutral: NDArray[np.float64], fapu: Fapu, /) -> NDArray[np.float64]:
    """Return how far control points are from the neutral pose, (n, 3) in FAPU units.

    points, neutral : (n, 3) cm in face axes, of the same face
    """
    moved = points - neutral
    for pupil, corners in _EYES:
        moved[pupil] -= moved[corners].mean(axis=0)
        moved[pupil, 2] = 0.0
    moved[:, 2] *= _DEPTH_TRUST
    units = moved / fapu.lengths()
    for upper, lower in _LIDS:
        open_gap = (neutral[upper, 1] - neutral[lower, 1]) * (1 - SHUT_LID_GAP)
        gap = points[upper, 1] - points[lower, 1] - open_gap * SHUT_LID_GAP / (1 - SHUT_LID_GAP)
        openness = max(gap / open_gap, 0.0)
        units[upper, 1] = units[lower, 1] + (openness - 1) * UNITS_PER_DISTANCE
    return units


_LIDS = [(INDEX[f"eyelid_upper_{side}"], INDEX[f"eyelid_lower_{side}"]) for side in "lr"]
_EYES = [(INDEX[f"pupil_{s}"], [INDEX[f"eye_inner_corner_{s}"], INDEX[f"eye_outer_corner_{s}"]]) for s in "lr"]


def _per_point(usual: float, **by_name: float) -> NDArray[np.float64]:
    """Return (n, 1): a number for each control point, by the start of its name."""
    values = np.full((CONTROL_POINT_COUNT, 1), usual)
    for name, value in by_name.items():
        values[indices(name)] = value
    return values


# Hz, and Hz for each cm a second.
_MIN_CUTOFF = _per_point(1.5, eyelid=4.0, inner_lip=2.5, outer_lip=2.5, cupids_bow=2.5, pupil=2.0)
_BETA = _per_point(2.0, eyelid=4.0, pupil=4.0)
_DEPTH_TRUST = _per_point(1.0)[:, 0]
_POSE_MIN_CUTOFF = np.array([1.5, 1.5, 1.5, 2.0, 2.0, 1.5])
_POSE_BETA = np.array([8.0, 8.0, 8.0, 20.0, 20.0, 8.0])  # radians, picture heights, e-folds a second
