"""The sending half of a call: motion and portrait out, reports in, as message bodies. No I/O, no clock, no sealing."""

from dataclasses import dataclass, replace

from conf.errors import ProtocolError
from conf.protocol import messages
from conf.protocol.codec.profiles import PROFILES
from conf.protocol.motion.outbound import OutboundMotion, OutgoingBody
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.send_budget import DATAGRAM_OVERHEAD, RateOptions, SendBudget
from conf.protocol.wire import decode_body, encode_body

PIGGYBACK_BYTES = 2  # overhead of a chunk in a datagram with motion
MAX_PIGGYBACK_MOTION = 255  # bytes of motion: its length is one byte
# A chunk in a datagram with motion needs no headers; without motion for so long it is sent alone. During startup a
# frame's time must do: a still face sends no motion, and its portrait would have to wait.
MAX_PIGGYBACK_WAIT_S = 0.2
STARTUP_PIGGYBACK_WAIT_S = 0.06
ROUND_TRIP_INTERVAL_S = 10.0


@dataclass(frozen=True)
class LinkStatus:
    """The state of the link as far as reports tell; None where none has arrived yet."""

    connected: bool
    stopped: bool
    profile: str
    frames_per_datagram: int
    round_trip_ms: float | None
    loss_percent: float | None
    jitter_ms: float | None


class SendLeg:
    """Turn one person's motion and portrait into message bodies within the send budget.

    The owner seals the bodies, reports each with `on_sent`, and hands in the bodies that it receives.
    motion : the outgoing motion stream; budget : what may be sent
    """

    def __init__(
        self,
        parameters: messages.StreamParameters,
        now: float,
        *,
        rate: RateOptions | None = None,
        portrait: ObjectSender | None = None,
    ) -> None:
        """portrait : the objects of the sender's portrait, None to send none"""
        self.motion = OutboundMotion(parameters)
        self.budget = SendBudget(rate or RateOptions(), now)
        self._portrait = portrait
        self._connected = False
        self._timestamp = 0.0
        self._piggybacked_at = float("-inf")
        self._sent_round_trip_ms = 0.0
        self._round_trip_due = now
        self._apply_level()

    def start(self, now: float) -> None:
        """Begin to send in a new session, whose receiver knows nothing."""
        self._connected = True
        self.budget.restart(now)
        self.motion.restart()
        if self._portrait:
            self._portrait.restart()

    def stop(self) -> None:
        """Stop sending: the session has ended."""
        self._connected = False

    def send_frame(self, frame: messages.MotionFrame, now: float) -> None:
        """Send one frame; it is dropped while there is no session or the budget is stopped."""
        self._timestamp = frame.timestamp
        if self._may_send(now):
            self.motion.send_frame(frame, now)

    def send_no_face(self, timestamp: float, now: float) -> None:
        """Report that there is no face at `timestamp`."""
        self._timestamp = timestamp
        if self._may_send(now):
            self.motion.send_no_face(timestamp, now)

    def bodies_to_send(self, now: float) -> list[OutgoingBody]:
        """Return the bodies to send now. One that exceeds the user's limit is dropped, as if lost on the network."""
        bodies = self.motion.drain() + self._round_trip_message(now)
        if self._connected and self.budget.take_probe(now):
            bodies = [self.motion.probe(self._timestamp)]
        return self._within_limit(self._with_chunk(bodies, now), now)

    def closing_bodies(self, now: float) -> list[OutgoingBody]:
        """Return the bodies that end the call: two, as one may be lost."""
        return self._within_limit([OutgoingBody(encode_body(messages.Bye()))] * 2, now)

    def on_sent(self, counter: int, outgoing: OutgoingBody, now: float) -> None:
        """Record the counter of the datagram in which a body was sent."""
        self.motion.on_sent(counter, outgoing)
        self.budget.round_trip.on_sent(counter, now)

    def receive_body(self, data: bytes, now: float) -> int | None:
        """Apply a body from the receiver; a malformed one is ignored.

        Returns the newest counter that the receiver is now known to have, None if the body tells none.
        """
        try:
            match decode_body(data):
                case messages.Feedback() as feedback:
                    self._apply_feedback(feedback, now)
                    return feedback.report.highest
                case messages.PortraitAck(data=ack) if self._portrait:
                    if self._portrait.receive_ack(ack):
                        self.budget.chunks.restart()
        except ProtocolError:
            pass
        return None

    def status(self, now: float) -> LinkStatus:
        """Return the state of the link."""
        round_trip_s, loss, level = self.budget.round_trip.smoothed_s, self.budget.loss, self.budget.level
        return LinkStatus(
            connected=self._connected,
            stopped=self._connected and self.budget.is_stopped(now),
            profile=level.profile,
            frames_per_datagram=self.motion.profile.frames_per_datagram * level.bundling,
            round_trip_ms=None if round_trip_s is None else round_trip_s * 1000,
            loss_percent=loss.fraction * 100 if loss.expected else None,
            jitter_ms=self.budget.jitter_ms,
        )

    def _may_send(self, now: float) -> bool:
        return self._connected and not self.budget.is_stopped(now)

    def _apply_feedback(self, feedback: messages.Feedback, now: float) -> None:
        self.budget.on_report(feedback.report, now)
        if feedback.refresh:
            self.motion.drop_references()
        self.motion.on_acknowledged(feedback.report.acknowledged())
        self._apply_level()

    def _apply_level(self) -> None:
        level = self.budget.level
        self.motion.set_profile(PROFILES[level.profile], bundling=level.bundling)

    def _within_limit(self, bodies: list[OutgoingBody], now: float) -> list[OutgoingBody]:
        return [body for body in bodies if self.budget.take(len(body.body) + DATAGRAM_OVERHEAD, now)]

    def _round_trip_message(self, now: float) -> list[OutgoingBody]:
        """Return a message with the round trip time, seldom and only if it has changed: it costs a datagram."""
        round_trip_s = self.budget.round_trip.smoothed_s
        if round_trip_s is None or now < self._round_trip_due or not self._may_send(now):
            return []
        milliseconds = round_trip_s * 1000
        if abs(milliseconds - self._sent_round_trip_ms) < max(0.25 * self._sent_round_trip_ms, 5.0):
            return []
        self._round_trip_due, self._sent_round_trip_ms = now + ROUND_TRIP_INTERVAL_S, milliseconds
        return [OutgoingBody(encode_body(messages.RoundTripMessage(round(milliseconds))))]

    def _with_chunk(self, bodies: list[OutgoingBody], now: float) -> list[OutgoingBody]:
        """Add at most one portrait chunk, in the last motion's datagram where there is one."""
        if self._portrait is None or not self._connected or not self.budget.allows_chunk(now):
            return bodies
        motion = bodies[-1].motion if bodies and len(bodies[-1].body) <= MAX_PIGGYBACK_MOTION else None
        max_wait_s = STARTUP_PIGGYBACK_WAIT_S if self.budget.chunks.in_startup else MAX_PIGGYBACK_WAIT_S
        if motion is None and now < self._piggybacked_at + max_wait_s:
            return bodies
        overhead = DATAGRAM_OVERHEAD if motion is None else PIGGYBACK_BYTES
        data = self._portrait.next_chunk(now, self.budget.chunks, overhead=overhead)
        if motion is not None or data is not None:
            self._piggybacked_at = now
        if data is None:
            return bodies
        chunk = messages.PortraitChunk(data)
        if motion is None:
            return [*bodies, OutgoingBody(encode_body(chunk))]
        return [*bodies[:-1], replace(bodies[-1], body=encode_body(messages.MotionWithChunk(motion, chunk)))]
