"""Auto framing: keep the head centred and at a constant size in the rendered image.

A head may be small and off-centre in the sender's camera. The slow average of its position and size is removed; what
remains is nods and sways. Small ones are kept unchanged, large ones are limited softly, so that hair and chin stay
inside the image.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose

SETTLE_SECONDS = 3.0  # time constant of the average
# At the start the time constant is shorter, because a first position is seldom the mean position: it grows from
# FIRST_SETTLE_SECONDS by SETTLE_GROWTH seconds per second.
FIRST_SETTLE_SECONDS = 0.3
SETTLE_GROWTH = 0.5
CENTRE = np.array([0.0, -0.055])  # image heights: rest position of the face's origin, low to leave room for hair
LOG_SCALE = math.log(0.029)  # image heights per cm: the head fills seven tenths of the image height
LOG_GROWTH = math.log(1.2)  # limit of the enlargement when a person leans towards the camera, or back
MIN_ASPECT = 0.8  # width over height of the area below which the head is drawn smaller
MARGIN = 0.03  # image heights between the head and the edge of the area
PANEL_SHIFT = 0.6  # how far the head moves towards the middle of the area beside a panel; 0 is the image's middle
MIN_MOTION_ROOM = 0.015  # image heights that a head can always move

# Ellipsoid around the default head, hair and chin included, cm.
HEAD_CENTRE = np.array([0.0, 3.4, -3.5])
HEAD_RADII = np.array([9.8, 12.4, 11.5])


@dataclass(frozen=True)
class FrameArea:
    """Part of the image in which a head is kept: image heights from the centre, x right, y up."""

    left: float = -0.5
    right: float = 0.5
    bottom: float = -0.5
    top: float = 0.5

    @classmethod
    def of(cls, size: tuple[float, float], *, covered: float = 0.0) -> "FrameArea":
        """Return the area of an image of this width and height, of which `covered` is hidden at the left."""
        half = size[0] / size[1] / 2
        return cls(left=-half + covered / size[1], right=half)


def rest_pose(area: FrameArea) -> HeadPose:
    """Return the pose in which a head that looks straight ahead and does not move is drawn."""
    middle = np.array([PANEL_SHIFT * (area.left + area.right) / 2, 0.0])
    log_shrink = min(0.0, math.log((area.right - area.left) / MIN_ASPECT))
    return HeadPose(np.zeros(3), middle + CENTRE * math.exp(log_shrink), LOG_SCALE + log_shrink)


class AutoFraming:
    """The running average of one head's position and size."""

    def __init__(self) -> None:
        self._mean: NDArray[np.float64] | None = None
        self._began = self._now = 0.0

    def frame(self, pose: HeadPose, now: float, area: FrameArea | None = None) -> HeadPose:
        """Return the pose to draw for a received pose, at time `now` in seconds."""
        area = area or FrameArea()
        current = np.array([*pose.position, pose.log_scale])
        mean, rest = self._update_mean(current, now), rest_pose(area)
        log_scale = rest.log_scale + soft_clamp(float(current[2] - mean[2]), LOG_GROWTH)
        sway = math.exp(rest.log_scale - mean[2]) * (current - mean)[:2]
        centred = HeadPose(pose.rotation, rest.position, log_scale)
        return HeadPose(pose.rotation, _limited_position(centred, sway, area), log_scale)

    def _update_mean(self, current: NDArray[np.float64], now: float) -> NDArray[np.float64]:
        """Add a position and log scale (3,) to the average. Returns the average."""
        if self._mean is None:
            self._mean, self._began, self._now = current, now, now
        settle = min(SETTLE_SECONDS, FIRST_SETTLE_SECONDS + SETTLE_GROWTH * max(0.0, now - self._began))
        weight = 1 - math.exp(-max(0.0, now - self._now) / settle)
        self._mean = self._mean + weight * (current - self._mean)
        self._now = now
        return self._mean


def soft_clamp(offset: float, limit: float) -> float:
    """Return an offset limited smoothly to less than `limit`; a small one is almost unchanged."""
    return limit * math.tanh(offset / limit)


def head_bounds(pose: HeadPose) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the centre (2,) and half the width and height (2,) of the head in the image, image heights."""
    rotation, scale = pose.matrix()[:2], math.exp(pose.log_scale)
    half = np.sqrt(((rotation * HEAD_RADII) ** 2).sum(axis=1))
    return pose.position + scale * rotation @ HEAD_CENTRE, scale * half


def _limited_position(pose: HeadPose, sway: NDArray[np.float64], area: FrameArea) -> NDArray[np.float64]:
    """Return the position (2,) of a head that rests at `pose` and sways by (2,), so that it stays inside the area."""
    centre, half = head_bounds(pose)
    low = np.array([area.left, area.bottom]) + MARGIN + half
    high = np.array([area.right, area.top]) - MARGIN - half
    inside = np.where(low < high, np.clip(centre, low, high), (low + high) / 2)
    room = np.maximum(np.where(sway > 0, high - inside, inside - low), MIN_MOTION_ROOM)
    limited = [soft_clamp(float(offset), float(limit)) for offset, limit in zip(sway, room, strict=True)]
    return np.asarray(inside - (centre - pose.position) + limited)
