"""The incoming motion stream: message bodies in, motion to draw out. No I/O, no clock."""

from collections import deque
from dataclasses import dataclass

from conf.protocol.codec.decoder import Decoder
from conf.protocol.codec.payload_header import profile_of
from conf.protocol.messages import FurrowMessage, KeepAlive, MotionFrame, MotionPayload, Presence, StreamParameters
from conf.protocol.motion.jitter_buffer import JitterBuffer, PlayoutFrame
from conf.protocol.session.sequence import unwrap
from conf.protocol.statistics import RateWindow
from conf.protocol.stream_clocks import PeerStreamClock, PlayoutClock
from conf.protocol.wire import MAX_FURROW_LEVEL, NUMBER_BITS

MAX_RECEIVED = 256  # frames kept for a user that records them


@dataclass(frozen=True)
class ReceivedFrame:
    """A frame as it arrived. fps : rate of the sender's clock, of whose period its timestamp is a multiple"""

    frame: MotionFrame
    fps: float


class InboundMotion:
    """Decode the motion of one sender and play it out in time.

    parameters : None until they have been received
    frames : count and rate of the frames received; datagrams : that carried them
    received : the frames as they arrived, oldest first, for the user to remove; the newest MAX_RECEIVED
    """

    def __init__(self, playout: PlayoutClock | None = None, peer_clock: PeerStreamClock | None = None) -> None:
        """playout, peer_clock : shared with the voice of the same sender"""
        self.parameters: StreamParameters | None = None
        self.presence = Presence.FACE
        self.frames = RateWindow()
        self.datagrams = 0
        self.received: deque[ReceivedFrame] = deque(maxlen=MAX_RECEIVED)
        self.buffer = JitterBuffer(playout)
        self._decoder = Decoder()
        self._furrow = 0.0
        self._furrow_counter = -1  # of the datagram that told
        self._clock = peer_clock or PeerStreamClock()

    def frame_at(self, now: float) -> PlayoutFrame | None:
        """Return the motion to draw at `now`, or None before there is any."""
        return self.buffer.frame_at(now)

    def receive_parameters(self, parameters: StreamParameters, now: float) -> None:
        """Apply stream parameters."""
        self.parameters = parameters
        self._clock.set(parameters.clock, now)

    def receive_keep_alive(self, body: KeepAlive, now: float) -> None:
        """Apply a keep-alive: without motion, the last frame is still valid."""
        self.presence = body.presence
        self._clock.set(body.timestamp, now)
        if body.presence is Presence.FACE:
            self.buffer.repeat_until(body.timestamp, now)

    def receive_furrows(self, body: FurrowMessage, counter: int) -> None:
        """Apply the furrows of the frames from here on unless a newer datagram has told others. counter : of its own"""
        if counter > self._furrow_counter:
            self._furrow, self._furrow_counter = body.level / MAX_FURROW_LEVEL, counter

    def receive_motion(self, body: MotionPayload, now: float) -> float:
        """Decode frames. Returns the timestamp of the newest, seconds on the sender's stream clock.

        Raises ProtocolError, and its child MissingReferenceError if a reference frame has not arrived.
        """
        profile = profile_of(body.payload)
        decoded = self._decoder.decode(body.payload, self._frame_number(body.frame_number, profile.fps, now))
        self.datagrams += 1
        self.presence = Presence.FACE
        for frame in decoded:
            timestamp = frame.frame_number / profile.fps
            self.frames.add(1, now)
            motion = MotionFrame(timestamp, frame.displacements, frame.pose, self._furrow)
            self.received.append(ReceivedFrame(motion, profile.fps))
            self.buffer.add(motion, now)
        self._clock.advance(timestamp, now)
        return timestamp

    def _frame_number(self, low_bits: int, fps: float, now: float) -> int:
        """Return the frame number. Numbers start at 0 in each session, so the first need no clock."""
        stream_time = self._clock.time(now)
        if stream_time is None:
            return low_bits
        return unwrap(low_bits, bits=NUMBER_BITS, expected=max(0, round(stream_time * fps)))
