"""What the two halves say to each other, as plain values. WIRE.md says how each looks in bytes."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from conf.protocol.feedback import Report


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


@dataclass(frozen=True)
class MotionPayload:
    """One or more coded frames.

    number : of the first frame, its low seven bits
    payload : as the codec wrote it
    """

    frame_number: int
    payload: bytes


@dataclass(frozen=True)
class Feedback:
    """A report, and whether the receiver misses a reference: then nothing may be predicted from what it had."""

    report: Report
    refresh: bool


@dataclass(frozen=True)
class RoundTripMessage:
    """The sender tells the receiver, who cannot know it, how long the way there and back is."""

    milliseconds: int


@dataclass(frozen=True)
class Bye:
    """The sender hangs up."""


@dataclass(frozen=True)
class PortraitChunk:
    """A piece of a picture of the sender. data : as conf.protocol.portrait wrote it, and checks it"""

    data: bytes


@dataclass(frozen=True)
class PortraitAck:
    """What the receiver has of the sender's picture. data : as conf.protocol.portrait wrote it, and checks it"""

    data: bytes


@dataclass(frozen=True)
class MotionWithChunk:
    """Motion and a piece of a picture in one datagram: the headers are paid once."""

    motion: MotionPayload
    chunk: PortraitChunk


Body = (
    MotionPayload
    | StreamParameters
    | KeepAlive
    | Feedback
    | RoundTripMessage
    | Bye
    | PortraitChunk
    | PortraitAck
    | MotionWithChunk
)
