"""The sender's end of a call: its session and its motion together, in the shape of aioquic. No I/O, no clock.

Bodies leave sealed, as fast as congestion control, the cap and the circuit breaker let them; reports come back and
steer all three.
"""

from collections import deque
from dataclasses import dataclass, replace

from conf.errors import ProtocolError
from conf.protocol.address import Address
from conf.protocol.circuit_breaker import CircuitBreaker
from conf.protocol.codec import NARROWBAND, PROFILES
from conf.protocol.congestion import RATE_LEVELS, CongestionControl
from conf.protocol.feedback import RoundTripEstimator
from conf.protocol.messages import (
    Bye,
    Feedback,
    MotionFrame,
    MotionWithChunk,
    PortraitAck,
    PortraitChunk,
    RoundTripMessage,
    StreamParameters,
)
from conf.protocol.motion.outbound import OutboundMotion, OutgoingBody
from conf.protocol.portrait import ObjectSender
from conf.protocol.portrait.object_sender import WIRE_PIECE_BYTES
from conf.protocol.rate_limit import RateLimiter
from conf.protocol.session.client import SenderSession
from conf.protocol.session.events import BodyReceived, Connected, Event
from conf.protocol.statistics import HEADER_BYTES, RateWindow
from conf.protocol.wire import decode_body, encode_body

AUTOMATIC = "auto"
SEALED_BYTES = 19  # what framing and seal add at the most
AUTOMATIC_TOP = 1  # live: who wants thirty frames a second says so
PIGGYBACK_BYTES = 2  # what joining two bodies costs
PIECE_ROOM = HEADER_BYTES + SEALED_BYTES + WIRE_PIECE_BYTES  # what a piece costs at the most
# A piece that rides with motion costs no headers: without motion for so long it goes alone. At the start a
# frame's time must do, or a still face, which sends no motion, would keep its picture waiting.
MAX_PIGGYBACK_WAIT_S = 0.2
START_WAIT_FOR_RIDE_S = 0.06
TELL_ROUND_TRIP_S = 10.0
RUNG_KBPS = (11.0, 5.8, 4.0, 2.4)  # what each rung of the ladder needs


@dataclass(frozen=True)
class RateOptions:
    """What the user says about the link.

    profile : live, narrow or rich, or AUTOMATIC to follow the reports
    kbps : cap, headers included, None for none
    """

    profile: str = AUTOMATIC
    kbps: float | None = None


@dataclass(frozen=True)
class LinkStatus:
    """How the link fares, as far as reports tell; None where none has come yet."""

    connected: bool
    stopped: bool
    profile: str
    frames_per_datagram: int
    round_trip_ms: float | None
    loss_percent: float | None
    jitter_ms: float | None


def highest_level(kbps: float | None) -> int:
    """Return the highest rung of the ladder that fits under a cap, the lowest if none does."""
    fitting = (i for i, need in enumerate(RUNG_KBPS) if kbps is None or need <= kbps)
    return max(next(fitting, len(RATE_LEVELS) - 1), AUTOMATIC_TOP)


class SenderConnection:
    """One sender's call to the receiver at `remote`."""

    def __init__(
        self,
        session: SenderSession,
        parameters: StreamParameters,
        now: float,
        *,
        link: RateOptions | None = None,
        portrait: ObjectSender | None = None,
    ) -> None:
        """portrait : what is to be sent of the sender's picture, None to send nothing of it"""
        link = link or RateOptions()
        top = highest_level(link.kbps)
        self.traffic = RateWindow()
        self.outbound = OutboundMotion(parameters)
        self._session = session
        self._portrait = portrait
        self._automatic = link.profile == AUTOMATIC
        self._congestion = CongestionControl(now, top=top, start=top)
        self._cap = RateLimiter(link.kbps) if link.kbps else None
        self._breaker = CircuitBreaker(now)
        self._round_trip = RoundTripEstimator()
        self._jitter_ms: float | None = None
        self._bundling = 1
        self._events: deque[Event] = deque()
        self._timestamp = 0.0
        self._rode_at = float("-inf")
        self._trip_told_ms = 0.0
        self._trip_due = now
        if self._automatic:
            self._follow_congestion()
        else:
            self.outbound.set_profile(PROFILES[link.profile])

    def send_frame(self, frame: MotionFrame, now: float) -> None:
        """Take one frame's motion; without a session it is forgotten."""
        self._timestamp = frame.timestamp
        if self._may_send(now):
            self.outbound.send_frame(frame, now)

    def send_no_face(self, timestamp: float, now: float) -> None:
        """Note that there is no face at `timestamp`."""
        self._timestamp = timestamp
        if self._may_send(now):
            self.outbound.send_absence(timestamp, now)

    def receive_datagram(self, data: bytes, address: Address, now: float) -> None:
        """Take a datagram, whatever its bytes."""
        self._session.receive_datagram(data, address, now)
        self._take_events(now)

    def datagrams_to_send(self, now: float) -> list[tuple[bytes, Address]]:
        """Take what is to be sent now."""
        datagrams = [d for d in self._session.datagrams_to_send(now) if self._fits(len(d[0]), now)]
        self._take_events(now)
        outgoing = self.outbound.drain() + self._round_trip_message(now)
        if self._session.session is not None and self._breaker.take_probe(now):
            outgoing = [self.outbound.probe(self._timestamp)]
        pieces_before = self._portrait.bytes_sent if self._portrait else 0
        outgoing = self._with_portrait(outgoing, now)
        datagrams += [sealed for body in outgoing if (sealed := self._seal(body, now))]
        if self._portrait and datagrams:
            total = sum(len(data) + HEADER_BYTES for data, _ in datagrams)
            self._portrait.account_motion(total - (self._portrait.bytes_sent - pieces_before), now)
        return self._counted(datagrams, now)

    def close(self, now: float) -> list[tuple[bytes, Address]]:
        """Return the datagrams that tell the receiver that the call is over: two, as one may be lost."""
        goodbye = OutgoingBody(encode_body(Bye()))
        return self._counted([sealed for _ in range(2) if (sealed := self._seal(goodbye, now))], now)

    def next_event(self) -> Event | None:
        """Take the next event, oldest first."""
        return self._events.popleft() if self._events else None

    def status(self, now: float) -> LinkStatus:
        """Return how the link fares."""
        trip = self._round_trip.smoothed_s
        loss = self._congestion.loss
        return LinkStatus(
            connected=self._session.session is not None,
            stopped=self._session.session is not None and self._breaker.is_open(now),
            profile=self.outbound.profile.name,
            frames_per_datagram=self.outbound.profile.frames_per_datagram * self._bundling,
            round_trip_ms=None if trip is None else trip * 1000,
            loss_percent=loss.fraction * 100 if loss.expected else None,
            jitter_ms=self._jitter_ms,
        )

    def _take_events(self, now: float) -> None:
        while event := self._session.next_event():
            match event:
                case BodyReceived(body=body):
                    self._take(body, now)
                case Connected():
                    self._breaker.on_report(now)
                    self.outbound.restart()
                    if self._portrait:
                        self._portrait.restart()
                    self._events.append(event)
                case _:
                    self._events.append(event)

    def _counted(self, datagrams: list[tuple[bytes, Address]], now: float) -> list[tuple[bytes, Address]]:
        for data, _ in datagrams:
            self.traffic.add(len(data) + HEADER_BYTES, now)
        return datagrams

    def _round_trip_message(self, now: float) -> list[OutgoingBody]:
        """Tell the receiver the round trip, seldom and only when it is news: it costs a datagram."""
        trip = self._round_trip.smoothed_s
        if trip is None or now < self._trip_due or not self._may_send(now):
            return []
        if abs(trip * 1000 - self._trip_told_ms) < max(0.25 * self._trip_told_ms, 5.0):
            return []
        self._trip_due, self._trip_told_ms = now + TELL_ROUND_TRIP_S, trip * 1000
        return [OutgoingBody(encode_body(RoundTripMessage(round(trip * 1000))))]

    def _with_portrait(self, outgoing: list[OutgoingBody], now: float) -> list[OutgoingBody]:
        """Add one piece of the picture at the most, in the last motion's datagram where there is one."""
        if self._portrait is None or not self._has_room_for_portrait(now):
            return outgoing
        piggybacks = bool(outgoing) and outgoing[-1].motion is not None and len(outgoing[-1].body) < 256
        patience = START_WAIT_FOR_RIDE_S if self._portrait.in_startup else MAX_PIGGYBACK_WAIT_S
        if not piggybacks and now < self._rode_at + patience:
            return outgoing
        piece = self._portrait.next_chunk(now, overhead=PIGGYBACK_BYTES if piggybacks else HEADER_BYTES + SEALED_BYTES)
        if piggybacks or piece is not None:
            self._rode_at = now
        if piece is None:
            return outgoing
        if not piggybacks:
            return [*outgoing, OutgoingBody(encode_body(PortraitChunk(piece)))]
        *before, last = outgoing
        assert last.motion is not None
        return [*before, replace(last, body=encode_body(MotionWithChunk(last.motion, PortraitChunk(piece))))]

    def _has_room_for_portrait(self, now: float) -> bool:
        """Whether a piece would keep no motion waiting: not behind a queue, not under a cap that motion nearly fills.

        A modem has no room; but heavy loss alone also leads to `narrow`.
        """
        if not self._may_send(now) or self._congestion.queue_is_high(self._round_trip):
            return False
        if self.outbound.profile == NARROWBAND and not self._automatic:
            return False
        return self._cap is None or self._cap.has_headroom(PIECE_ROOM, now)

    def _may_send(self, now: float) -> bool:
        return self._session.session is not None and not self._breaker.is_open(now)

    def _seal(self, outgoing: OutgoingBody, now: float) -> tuple[bytes, Address] | None:
        """Seal a body, unless the cap forbids it: then it is lost like a datagram on the way."""
        if not self._fits(len(outgoing.body) + SEALED_BYTES, now):
            return None
        sealed = self._session.seal_body(outgoing.body)
        if sealed is None:
            return None
        self.outbound.on_sent(sealed.counter, outgoing)
        self._round_trip.sent(sealed.counter, now)
        return sealed.datagram, sealed.address

    def _fits(self, size: int, now: float) -> bool:
        return self._cap is None or self._cap.take(size + HEADER_BYTES, now)

    def _take(self, body: bytes, now: float) -> None:
        try:
            match decode_body(body):
                case Feedback() as feedback:
                    self._take_feedback(feedback, now)
                case PortraitAck(data=data) if self._portrait:
                    self._portrait.receive_answer(data)
        except ProtocolError:
            return

    def _take_feedback(self, feedback: Feedback, now: float) -> None:
        report = feedback.report
        self._breaker.on_report(now)
        self._round_trip.on_report(report, now)
        self._congestion.reported(report, self._round_trip, now)
        self._jitter_ms = float(report.jitter_ms)
        self._session.acknowledge(report.highest)
        if feedback.refresh:
            self.outbound.drop_references()
        self.outbound.on_acknowledged(report.acknowledged())
        if self._automatic:
            self._follow_congestion()

    def _follow_congestion(self) -> None:
        rung = self._congestion.rung
        self._bundling = rung.bundling
        self.outbound.set_profile(PROFILES[rung.profile], bundling=rung.bundling)
