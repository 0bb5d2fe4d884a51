"""The receiving half of a call: message bodies in; motion, portrait objects and reports out. No I/O, no clock."""

from collections import deque

from conf.errors import ProtocolError
from conf.protocol import messages
from conf.protocol.codec.reference_frames import MissingReferenceError
from conf.protocol.motion.inbound import InboundMotion
from conf.protocol.portrait.object_receiver import ObjectReceiver
from conf.protocol.reception_statistics import ReceptionStatistics
from conf.protocol.statistics import RateWindow, TrafficSnapshot, raw_frame_bytes
from conf.protocol.wire import decode_body, encode_body

SILENCE_S = 3.0
MAX_OBJECTS = 64  # received objects that wait to be used


class ReceiveLeg:
    """Receive what one sender sends. Knows nothing of sealing.

    motion : the incoming motion stream
    received_objects : complete objects of the sender's portrait, oldest first, for the user to remove
    traffic : bytes received, headers included
    last_received : when the newest datagram came, None before the first
    rejected : malformed bodies; missed_references : frames whose reference had not arrived
    round_trip_ms : as the sender measured it, None before it has told; ended : whether the sender has ended the call
    """

    def __init__(self, receiver_id: int = 0) -> None:
        """receiver_id : 16 bits by which the sender recognises the receiver of its portrait"""
        self.motion = InboundMotion()
        self.received_objects: deque[bytes] = deque(maxlen=MAX_OBJECTS)
        self.traffic = RateWindow()
        self.rejected = 0
        self.missed_references = 0
        self.round_trip_ms: float | None = None
        self.ended = False
        self._object_receiver = ObjectReceiver(receiver_id)
        self._reception = ReceptionStatistics()
        self.last_received: float | None = None
        self._refresh_needed = False
        self._reported_at = float("-inf")

    def receive_body(self, data: bytes, counter: int, wire_bytes: int, now: float) -> None:
        """Apply one authenticated body. A malformed one is counted in `rejected` and changes nothing else.

        counter : of its datagram; wire_bytes : the datagram's size, headers included
        """
        self.traffic.add(wire_bytes, now)
        self.last_received = now
        timestamp, decodable = None, False
        try:
            timestamp = self._apply(decode_body(data), now)
            decodable = True
        except MissingReferenceError:
            self._refresh_needed = True
            self.missed_references += 1
        except ProtocolError:
            self.rejected += 1
        self._reception.add(counter, now, timestamp=timestamp, decodable=decodable)

    def is_silent(self, now: float) -> bool:
        """Return whether nothing has been received for a while, or ever."""
        return self.last_received is None or now - self.last_received > SILENCE_S

    def bodies_to_send(self, now: float) -> list[bytes]:
        """Return the bodies to seal and send back: a report and a portrait acknowledgement, each when due."""
        ack = self._object_receiver.next_ack(now)
        bodies = [self._report(now), encode_body(messages.PortraitAck(ack)) if ack else None]
        return [body for body in bodies if body]

    def snapshot(self, now: float) -> TrafficSnapshot:
        """Return the traffic figures."""
        parameters, frames = self.motion.parameters, self.motion.frames
        raw = raw_frame_bytes(parameters.width, parameters.height) if parameters else 0
        received = max(frames.count, 1)
        return TrafficSnapshot(
            frames_received=frames.count,
            frames_lost=round(self._reception.lost * received / max(self.motion.datagrams, 1)),
            frames_late=self.motion.buffer.late,
            datagrams=self.traffic.count,
            rejected=self.rejected,
            fps=frames.rates(now)[1],
            wire_bytes_per_frame=self.traffic.total / received,
            wire_kbps=self.traffic.rates(now)[0] * 8 / 1000,
            raw_bytes_per_frame=raw,
            raw_kbps=raw * (parameters.fps if parameters else 0.0) * 8 / 1000,
            ratio=raw * frames.count / self.traffic.total if self.traffic.total else 0.0,
            jitter_ms=self._reception.jitter.seconds * 1000,
            playout_delay_ms=self.motion.buffer.playout_delay_s * 1000,
        )

    def _apply(self, body: messages.Body, now: float) -> float | None:
        """Apply a body. Returns the timestamp of its newest frame, seconds on the sender's clock, None without one."""
        match body:
            case messages.StreamParameters():
                self.motion.receive_parameters(body, now)
            case messages.KeepAlive():
                self.motion.receive_keep_alive(body, now)
            case messages.MotionPayload():
                return self.motion.receive_motion(body, now)
            case messages.RoundTripMessage(milliseconds=milliseconds):
                self.round_trip_ms = float(milliseconds)
            case messages.PortraitChunk(data=data):
                self._receive_chunk(data)
            case messages.MotionWithChunk(motion=motion, chunk=chunk):
                self._receive_chunk(chunk.data)
                return self.motion.receive_motion(motion, now)
            case messages.Bye():
                self.ended = True
            case messages.Feedback() | messages.PortraitAck():
                raise ProtocolError("a message for a sender came to a receiver")
        return None

    def _receive_chunk(self, data: bytes) -> None:
        if complete := self._object_receiver.receive_chunk(data):
            self.received_objects.append(complete)

    def _report(self, now: float) -> bytes | None:
        if self.last_received is None or self.last_received <= self._reported_at:
            return None
        report = self._reception.report(now)
        if report is None:
            return None
        refresh, self._refresh_needed, self._reported_at = self._refresh_needed, False, now
        return encode_body(messages.Feedback(report, refresh))
