"""Keep the head well placed in the receiver's picture, whatever the sender's camera saw.

As sent, a head may sit small in a corner. Centred, the slow average of its place and size is taken out and what
remains, the nods and sways, is kept: small ones whole, large ones held back softly, so that hair and chin stay inside.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose

SETTLE_SECONDS = 3.0  # how fast the picture follows a person who moves to another seat
SETTLE_GROWTH = 0.5  # at first it follows faster: nobody's first place is the middle of where they will be
FIRST_SETTLE_SECONDS = 0.3
CENTRE = np.array([0.0, -0.055])  # picture heights: where the face's origin rests, a little low to leave room for hair
LOG_SCALE = math.log(0.029)  # a model centimetre in picture heights: the head fills seven tenths of the height
LOG_GROWTH = math.log(1.2)  # the most that leaning towards the camera, or back, enlarges or shrinks the head
MIN_ASPECT = 0.8  # width over height of a picture below which the head is drawn smaller
MARGIN = 0.03  # picture heights between the head and the picture's edge
PANEL_SHIFT = 0.6  # how far towards the middle of an area beside a panel the head goes: 0 stays in the picture's middle
MIN_MOTION_ROOM = 0.015  # so much a head always moves

# An ellipsoid around the default head, hair and chin included; model centimetres.
HEAD_MIDDLE = np.array([0.0, 3.4, -3.5])
HEAD_RADII = np.array([9.8, 12.4, 11.5])


@dataclass(frozen=True)
class FrameArea:
    """The part of the picture that a head is kept in: picture heights from the centre, x right, y up."""

    left: float = -0.5
    right: float = 0.5
    bottom: float = -0.5
    top: float = 0.5

    @classmethod
    def of(cls, size: tuple[float, float], *, covered: float = 0.0) -> "FrameArea":
        """Return the area of a picture of this width and height, so much of which is covered from the left."""
        half = size[0] / size[1] / 2
        return cls(left=-half + covered / size[1], right=half)


def rest_pose(area: FrameArea) -> HeadPose:
    """Return where a head that looks straight ahead and does not move is drawn."""
    middle = np.array([PANEL_SHIFT * (area.left + area.right) / 2, 0.0])
    smaller = min(0.0, math.log((area.right - area.left) / MIN_ASPECT))
    return HeadPose(np.zeros(3), middle + CENTRE * math.exp(smaller), LOG_SCALE + smaller)


class AutoFraming:
    """The running average of one head's place and size."""

    def __init__(self) -> None:
        self._mean: NDArray[np.float64] | None = None
        self._began = self._now = 0.0

    def frame(self, pose: HeadPose, now: float, area: FrameArea | None = None) -> HeadPose:
        """Return the pose to draw for a pose as sent, at time `now` in seconds."""
        area = area or FrameArea()
        seen = np.array([*pose.position, pose.log_scale])
        mean, still = self._follow(seen, now), rest_pose(area)
        log_scale = still.log_scale + soft_clamp(float(seen[2] - mean[2]), LOG_GROWTH)
        sway = math.exp(still.log_scale - mean[2]) * (seen - mean)[:2]
        turned = HeadPose(pose.rotation, still.position, log_scale)
        return HeadPose(pose.rotation, _kept_inside(turned, sway, area), log_scale)

    def _follow(self, seen: NDArray[np.float64], now: float) -> NDArray[np.float64]:
        """Take one more place and size (3,) into the average. Returns it."""
        if self._mean is None:
            self._mean, self._began, self._now = seen, now, now
        settle = min(SETTLE_SECONDS, FIRST_SETTLE_SECONDS + SETTLE_GROWTH * max(0.0, now - self._began))
        share = 1 - math.exp(-max(0.0, now - self._now) / settle)
        self._mean = self._mean + share * (seen - self._mean)
        self._now = now
        return self._mean


def soft_clamp(offset: float, room: float) -> float:
    """Return an offset held back so that it never exceeds the room; a small one stays as it is."""
    return room * math.tanh(offset / room)


def head_bounds(pose: HeadPose) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the middle (2,) and half the width and height (2,) of the head in the picture, picture heights."""
    turn, scale = pose.matrix()[:2], math.exp(pose.log_scale)
    half = np.sqrt(((turn * HEAD_RADII) ** 2).sum(axis=1))
    return pose.position + scale * turn @ HEAD_MIDDLE, scale * half


def _kept_inside(pose: HeadPose, sway: NDArray[np.float64], area: FrameArea) -> NDArray[np.float64]:
    """Return the place of a head that rests at `pose` and has swayed away by so much."""
    middle, half = head_bounds(pose)
    low = np.array([area.left, area.bottom]) + MARGIN + half
    high = np.array([area.right, area.top]) - MARGIN - half
    middle = np.where(low < high, np.clip(middle, low, high), (low + high) / 2)
    room = np.where(sway > 0, high - middle, middle - low)
    held = [
        soft_clamp(float(offset), max(float(most), MIN_MOTION_ROOM)) for offset, most in zip(sway, room, strict=True)
    ]
    anchor = middle - (head_bounds(pose)[0] - pose.position)
    return np.asarray(anchor + held)
