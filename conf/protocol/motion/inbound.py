"""The receiving half of the motion: opened bodies in, motion to draw out. No I/O, no clock."""

from collections import deque

from conf.errors import ProtocolError
from conf.protocol.codec import Decoder, MissingReferenceError
from conf.protocol.codec.payload_header import profile_of
from conf.protocol.feedback import ReceptionStats
from conf.protocol.messages import (
    Body,
    Bye,
    Feedback,
    KeepAlive,
    MotionFrame,
    MotionPayload,
    MotionWithChunk,
    PortraitAck,
    PortraitChunk,
    Presence,
    RoundTripMessage,
    StreamParameters,
)
from conf.protocol.motion.jitter_buffer import JitterBuffer, PlayoutFrame
from conf.protocol.portrait import ObjectReceiver
from conf.protocol.sequence import unwrap
from conf.protocol.statistics import RateWindow, TrafficSnapshot, raw_frame_bytes
from conf.protocol.wire import NUMBER_BITS, decode_body, encode_body

SILENCE_S = 3.0
MAX_OBJECTS = 64  # parts of a picture that nobody has taken yet


class InboundMotion:
    """Take the bodies of one sender and play its motion at its time."""

    def __init__(self, receiver_id: int = 0) -> None:
        """token : 16 bits that tell the sender whether this is still the receiver that it sent its picture to"""
        self.parameters: StreamParameters | None = None
        self.presence = Presence.FACE
        self.round_trip_ms: float | None = None
        self.ended = False
        self.received_objects: deque[bytes] = deque(maxlen=MAX_OBJECTS)  # what has come whole of the sender's picture
        self.rejected = 0
        self.missed_references = 0
        self.frames = RateWindow()
        self.traffic = RateWindow()
        self._portrait_inbox = ObjectReceiver(receiver_id)
        self._decoder = Decoder()
        self._buffer = JitterBuffer()
        self._reception = ReceptionStats()
        self._clock: tuple[float, float] | None = None  # the sender's stream time, and ours when we learned of it
        self._last_received: float | None = None
        self._refresh = False
        self._motion_datagrams = 0
        self._reported_at = float("-inf")

    def receive_body(self, data: bytes, counter: int, wire_bytes: int, now: float) -> None:
        """Take one body under a valid seal. A bad one is counted in `rejected` and changes nothing else.

        counter : of its datagram; wire_bytes : the datagram's size on the wire, headers counted
        """
        self.traffic.add(wire_bytes, now)
        self._last_received = now
        timestamp, understood = None, False
        try:
            timestamp = self._take(decode_body(data), now)
            understood = True
        except MissingReferenceError:
            self._refresh = True
            self.missed_references += 1
        except ProtocolError:
            self.rejected += 1
        self._reception.add(counter, now, timestamp=timestamp, decodable=understood)

    def frame_at(self, now: float) -> PlayoutFrame | None:
        """Return the motion to draw at `now`, or None before there is any."""
        return self._buffer.play(now)

    def is_silent(self, now: float) -> bool:
        """Say whether the sender has not been heard for a while, or never."""
        return self._last_received is None or now - self._last_received > SILENCE_S

    def bodies_to_send(self, now: float) -> list[bytes]:
        """Return what is to be sealed and sent back: a report, and what has come of the picture, each when due."""
        answer = self._portrait_inbox.next_ack(now)
        bodies = [self.feedback(now), encode_body(PortraitAck(answer)) if answer else None]
        return [body for body in bodies if body]

    def feedback(self, now: float) -> bytes | None:
        """Return a report when one is due and there is something to report."""
        if self._last_received is None or self._last_received <= self._reported_at:
            return None
        report = self._reception.report(now)
        if report is None:
            return None
        refresh, self._refresh, self._reported_at = self._refresh, False, now
        return encode_body(Feedback(report, refresh))

    def snapshot(self, now: float) -> TrafficSnapshot:
        """Return the figures of the meter."""
        bytes_a_second, _ = self.traffic.rates(now)
        _, fps = self.frames.rates(now)
        raw = raw_frame_bytes(self.parameters.width, self.parameters.height) if self.parameters else 0
        frames = max(self.frames.count, 1)
        return TrafficSnapshot(
            frames_received=self.frames.count,
            frames_lost=round(self._reception.lost * frames / max(self._motion_datagrams, 1)),
            frames_late=self._buffer.late,
            datagrams=self.traffic.count,
            rejected=self.rejected,
            fps=fps,
            wire_bytes_per_frame=self.traffic.total / frames,
            wire_kbps=bytes_a_second * 8 / 1000,
            raw_bytes_per_frame=raw,
            raw_kbps=raw * (self.parameters.fps if self.parameters else 0.0) * 8 / 1000,
            ratio=raw * self.frames.count / self.traffic.total if self.traffic.total else 0.0,
            jitter_ms=self._reception.jitter.seconds * 1000,
            playout_delay_ms=self._buffer.playout_delay_s * 1000,
        )

    def _take(self, body: Body, now: float) -> float | None:
        """Act on a body. Returns the time of the newest frame in it, seconds on the sender's clock, if it has any."""
        match body:
            case StreamParameters(clock=clock):
                self.parameters = body
                self._clock = (clock, now)
            case KeepAlive(timestamp=timestamp, presence=presence):
                self.presence = presence
                self._clock = (timestamp, now)
                if presence is Presence.FACE:
                    self._buffer.repeat_until(timestamp, now)
            case MotionPayload():
                return self._take_motion(body, now)
            case RoundTripMessage(milliseconds=milliseconds):
                self.round_trip_ms = float(milliseconds)
            case PortraitChunk(data=data):
                self._take_piece(data)
            case MotionWithChunk(motion=motion, chunk=piece):
                self._take_piece(piece.data)
                return self._take_motion(motion, now)
            case Bye():
                self.ended = True
            case _:
                raise ProtocolError("a report came to the receiver")
        return None

    def _take_piece(self, data: bytes) -> None:
        whole = self._portrait_inbox.receive_chunk(data)
        if whole:
            self.received_objects.append(whole)

    def _take_motion(self, body: MotionPayload, now: float) -> float:
        profile = profile_of(body.payload)
        number = self._number(body.frame_number, profile.fps, now)
        decoded = self._decoder.decode(body.payload, number)
        self._motion_datagrams += 1
        self.presence = Presence.FACE
        for frame in decoded:
            timestamp = frame.frame_number / profile.fps
            self.frames.add(1, now)
            self._buffer.add(MotionFrame(timestamp, frame.displacements, frame.pose), now)
        self._clock = max(self._clock or (timestamp, now), (timestamp, now))
        return timestamp

    def _number(self, low_bits: int, fps: int, now: float) -> int:
        """Return the number of a frame. Numbers start at 0 in each session, so the first need no clock."""
        if self._clock is None:
            return low_bits
        stream_time = self._clock[0] + now - self._clock[1]
        number = unwrap(low_bits, bits=NUMBER_BITS, expected=round(stream_time * fps))
        if number < 0:
            raise ProtocolError("a frame from before the stream")
        return number
