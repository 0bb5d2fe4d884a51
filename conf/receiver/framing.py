"""Keep the head well placed in the receiver's picture, whatever the sender's camera saw.

As sent, a head may sit small in a corner. Centred, the slow average of its place and size is taken out and what
remains, the nods and sways, is kept.
"""

import math

import numpy as np

from conf.face.head_pose import HeadPose

SETTLE_SECONDS = 3.0  # how fast the frame follows a person who moves to another seat
CENTRE = np.array([0.0, -0.025])  # picture heights: where the face's origin rests, a little low to leave room for hair
LOG_SCALE = math.log(0.0315)  # a model centimetre in picture heights: the head fills three quarters of the height


class Framer:
    """The running average of one head's place and size."""

    def __init__(self) -> None:
        self._mean: np.ndarray[tuple[int], np.dtype[np.float64]] | None = None
        self._now = 0.0

    def place(self, pose: HeadPose, now: float) -> HeadPose:
        """Return the pose to draw for a pose as sent, at time `now` in seconds."""
        seen = np.array([*pose.position, pose.log_scale])
        if self._mean is None:
            self._mean = seen
        else:
            share = 1 - math.exp(-max(0.0, now - self._now) / SETTLE_SECONDS)
            self._mean = self._mean + share * (seen - self._mean)
        self._now = now
        relative = seen - self._mean
        enlarged = math.exp(LOG_SCALE - self._mean[2])
        return HeadPose(pose.rotation, CENTRE + enlarged * relative[:2], LOG_SCALE + float(relative[2]))
