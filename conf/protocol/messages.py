"""What the two halves say to each other, as plain values. WIRE.md says how each looks in bytes."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class StreamParameters:
    """What a receiver must know before it can draw: repeated often enough that it may join late.

    width, height : the sender's picture in pixels, for the comparison with raw pixels
    fps : frames a second the sender means to send
    points : how many control points a frame carries
    fapu : the five FAPU distances of the sender's neutral face, es0 ens0 mns0 mw0 irisd0, in model centimetres
    clock : seconds on the stream's clock when this was sent; 0 is the first frame's capture
    """

    width: int
    height: int
    fps: float
    points: int
    fapu: tuple[float, ...]
    clock: float = 0.0


@dataclass(frozen=True)
class MotionFrame:
    """The motion of one captured frame.

    timestamp : seconds on the sender's clock, of the capture
    displacements : (n, 3) float32, in FAPU units, head pose removed
    pose : (6,) float64, rotation vector in radians, position in picture heights, log scale
    """

    timestamp: float
    displacements: NDArray[np.float32]
    pose: NDArray[np.float64]


class Presence(Enum):
    """Whether there is a face before the sender's camera."""

    FACE = 0
    NO_FACE = 1


@dataclass(frozen=True)
class KeepAlive:
    """The sender is there and has no motion to send: the face is still, or there is none.

    timestamp : seconds on the sender's clock
    """

    timestamp: float
    presence: Presence
