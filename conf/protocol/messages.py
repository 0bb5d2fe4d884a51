"""All messages between sender and receiver, and the motion they carry. WIRE.md describes their bytes."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from conf.protocol.feedback import Report
from conf.protocol.participant.state import CameraState
from conf.protocol.session.paths.candidates import PathCandidates
from conf.protocol.voice.formats import VoiceFormat, VoiceState


@dataclass(frozen=True)
class MotionFrame:
    """The motion of one captured frame.

    timestamp : capture time on the sender's clock, seconds
    displacements : (n, 3) float32, FAPU units, head pose removed
    pose : (6,) float64, rotation vector in radians, position in image heights, log scale
    furrow : depth of the furrows between the brows as far as the landmarks do not show them, 0 to 1
    """

    timestamp: float
    displacements: NDArray[np.float32]
    pose: NDArray[np.float64]
    furrow: float = 0.0


@dataclass(frozen=True)
class StreamParameters:
    """Stream parameters, repeated so that a receiver may join late.

    width, height : of the sender's image in pixels, for the comparison with raw video
    fps : frames per second that the sender intends to send
    points : number of control points in a frame
    fapu : FAPU distances of the sender's neutral face, es0 ens0 mns0 mw0 irisd0, model centimetres
    clock : stream time of sending, seconds; 0 is the capture of the first frame
    """

    width: int
    height: int
    fps: float
    points: int
    fapu: tuple[float, ...]
    clock: float = 0.0


class Presence(Enum):
    """Whether the sender's camera sees a face."""

    FACE = 0
    NO_FACE = 1


@dataclass(frozen=True)
class KeepAlive:
    """The sender is connected and has no motion to send. timestamp : seconds on the sender's clock"""

    timestamp: float
    presence: Presence


@dataclass(frozen=True)
class MotionPayload:
    """One or more coded frames.

    frame_number : of the first frame, modulo 128
    payload : from conf.protocol.codec
    """

    frame_number: int
    payload: bytes


@dataclass(frozen=True)
class FurrowMessage:
    """The furrows between the brows, until another message changes them. level : 0 to MAX_FURROW_LEVEL"""

    level: int


@dataclass(frozen=True)
class Feedback:
    """A reception report. refresh : a reference is missing, so nothing may be predicted from earlier frames"""

    report: Report
    refresh: bool


@dataclass(frozen=True)
class RoundTripMessage:
    """The round-trip time, which only the sender can measure."""

    milliseconds: int


@dataclass(frozen=True)
class Bye:
    """The sender ends the call."""


@dataclass(frozen=True)
class PortraitChunk:
    """A chunk of a portrait object. data : from conf.protocol.portrait, which checks it"""

    data: bytes


@dataclass(frozen=True)
class PortraitAck:
    """The chunks that the receiver has. data : from conf.protocol.portrait, which checks it"""

    data: bytes


@dataclass(frozen=True)
class ParticipantMessage:
    """Who sends, and what is to be shown of it.

    name : as clean_name returns it; camera : ON or OFF
    is_portrait_withdrawn : whether the images sent of the person are no longer to be shown
    head : number of the head that the participant has chosen, at most MAX_HEAD, 0 for none
    """

    name: str
    camera: CameraState
    is_portrait_withdrawn: bool = False
    head: int = 0


@dataclass(frozen=True)
class PathProbe:
    """The question whether the peer is at the address to which it was sent. The session has answered it."""

    token: bytes


@dataclass(frozen=True)
class PathAnswer:
    """The answer to a probe with the same token. The session has applied it."""

    token: bytes


@dataclass(frozen=True)
class VoicePayload:
    """One packet of voice.

    number : start of its first sample on the stream clock in units of 20 ms, modulo 512
    begins : whether nothing was said before it: there is no packet that ends where this one starts
    format_number : 0 to 15, of a VoiceFormatMessage
    data : the frames, from conf.protocol.voice.packing
    """

    number: int
    begins: bool
    format_number: int
    data: bytes


@dataclass(frozen=True)
class VoiceFormatMessage:
    """The format of all voice with this format number, until another message changes it."""

    format_number: int
    format: VoiceFormat


@dataclass(frozen=True)
class VoiceStateMessage:
    """What the microphone does. noise_level : of the background noise, -dBFS, 0 to 127"""

    state: VoiceState
    noise_level: int


SingleBody = (
    MotionPayload
    | FurrowMessage
    | StreamParameters
    | KeepAlive
    | Feedback
    | RoundTripMessage
    | Bye
    | PortraitChunk
    | PortraitAck
    | VoicePayload
    | VoiceFormatMessage
    | VoiceStateMessage
    | ParticipantMessage
    | PathProbe
    | PathAnswer
    | PathCandidates
)


@dataclass(frozen=True)
class Composite:
    """Several bodies in one datagram, which saves the headers of the others."""

    bodies: tuple[SingleBody, ...]


Body = SingleBody | Composite
