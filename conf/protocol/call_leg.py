"""One participant's end of a call over one session: a sending and a receiving half. No I/O, no clock, no sealing.

Strategy. Both ends take every kind of body. A body is decoded once and goes to the half that it concerns. Reports and
portrait acknowledgements ride in the datagrams of the sending half, if one is to be expected soon. A datagram that
carries nothing else calls for no report, or reports would answer reports for ever; now and then one of them is
acknowledged all the same, so that the counters of both directions stay short.
Source: RFC 9000, 13.2 (ack-eliciting packets).
"""

from collections.abc import Callable, Sequence

from conf.errors import ProtocolError
from conf.protocol import messages
from conf.protocol.codec.reference_frames import MissingReferenceError
from conf.protocol.outgoing import OutgoingBody, group_bodies, join_outgoing
from conf.protocol.receive_leg import ReceiveLeg
from conf.protocol.reception_statistics import REPORT_INTERVAL_S, ReceptionStatistics
from conf.protocol.send_leg import SendLeg
from conf.protocol.session.packet import MAX_OVERHEAD
from conf.protocol.session.paths.candidates import PathCandidates
from conf.protocol.statistics import HEADER_BYTES
from conf.protocol.wire import (
    FURROWS,
    KEEP_ALIVE,
    MOTION_BIT,
    PARAMETERS,
    PORTRAIT_CHUNK,
    REFRESH_REPORT,
    REPORT,
    VOICE_BIT,
    VOICE_STATE,
    decode_body,
    encode_body,
)

# Datagrams that call for no report, after which one rides all the same: counters are short up to 64 unacknowledged.
QUIET_DATAGRAMS = 32
_QUIET = (messages.Feedback, messages.PortraitAck, messages.PathProbe, messages.PathAnswer, PathCandidates)
# What a datagram goes without, one after another, when it exceeds the user's limit.
_VISUAL = (FURROWS, MOTION_BIT, PORTRAIT_CHUNK)
_DROPPED = ((), _VISUAL, (*_VISUAL, VOICE_BIT, PARAMETERS, KEEP_ALIVE))


class CallLeg:
    """Exchange bodies with one peer; the owner seals them, and tells of each what its counter was.

    send, receive : the halves; either may be absent
    ended : whether the peer has ended the call
    """

    def __init__(
        self,
        *,
        send: SendLeg | None = None,
        receive: ReceiveLeg | None = None,
        sealed_bytes: Callable[[int], int] = MAX_OVERHEAD.__add__,
    ) -> None:
        """sealed_bytes : size of a body -> size of the datagram that would carry it now"""
        self.send, self.receive = send, receive
        self.ended = False
        self._reception = receive.reception if receive else ReceptionStatistics()
        self._sealed_bytes = sealed_bytes
        self._portrait_ack: OutgoingBody | None = None  # due
        self._waiting_since: float | None = None  # acknowledgements wait for a datagram
        self._wait_s = 0.0

    def receive_body(self, data: bytes, counter: int, wire_bytes: int, now: float) -> int | None:
        """Apply one authenticated body. A malformed one is counted and changes nothing else.

        counter : of its datagram; wire_bytes : the datagram's size, headers included
        Returns the newest counter that the peer is now known to have received, None if the body tells none.
        """
        if self.receive:
            self.receive.on_datagram(data, wire_bytes, now)
        try:
            body = decode_body(data)
        except ProtocolError:
            self._reject()
            self._reception.add(counter, now, decodable=False)
            return None
        singles = body.bodies if isinstance(body, messages.Composite) else (body,)
        acknowledged, timestamp, decodable = None, None, True
        for single in singles:
            try:
                if isinstance(single, messages.Feedback):
                    acknowledged = single.report.highest
                end = self._apply(single, counter, now)
                timestamp = timestamp if end is None else end
            except MissingReferenceError:
                decodable = False
            except ProtocolError:
                self._reject()
                decodable = False
        quiet = all(isinstance(single, _QUIET) for single in singles)
        self._reception.add(counter, now, timestamp=timestamp, decodable=decodable, calls_for_report=not quiet)
        return acknowledged

    def bodies_to_send(self, now: float) -> list[OutgoingBody]:
        """Return the bodies to seal and send now, each for a datagram of its own, within the user's limit.

        What exceeds the limit is dropped, as if lost on the network, motion before voice.
        """
        acks = self._acks(now)
        reserved = sum(len(ack.body) + 1 for ack in acks)
        if self.send and reserved > self.send.room(now):
            acks, reserved = [], 0
        bodies = self.send.bodies_to_send(now, reserved=reserved) if self.send else []
        if not bodies and not self._must_send_acks(now):
            return []
        self._on_acks_sent(acks, now)
        return [sent for outgoing in self._datagrams(acks, bodies) if (sent := self._within_limit(outgoing, now))]

    def closing_bodies(self, now: float) -> list[OutgoingBody]:
        """Return the bodies that end the call, each for a datagram of its own."""
        bodies = self.send.closing_bodies() if self.send else []
        return [sent for body in bodies if (sent := self._within_limit([body], now))]

    def on_sent(self, counter: int, outgoing: OutgoingBody, now: float) -> None:
        """Record the counter of the datagram in which a body was sent."""
        if self.send:
            self.send.on_sent(counter, outgoing, now)

    def _apply(self, body: messages.SingleBody, counter: int, now: float) -> float | None:
        """Apply a body. Returns the stream time of the end of its content, None without any."""
        match body:
            case messages.Bye():
                self.ended = True
            case messages.Feedback():
                if self.send:
                    self.send.receive_report(body, now)
            case messages.PortraitAck():
                if self.send:
                    self.send.receive_portrait_ack(body)
            case _:
                return self.receive.receive(body, counter, now) if self.receive else None
        return None

    def _reject(self) -> None:
        if self.receive:
            self.receive.rejected += 1

    def _acks(self, now: float) -> list[OutgoingBody]:
        """Return the report and the portrait acknowledgement that are due, if only they find a datagram."""
        acks = []
        due = self._report_due(now) or (self.send and self._reception.quiet >= QUIET_DATAGRAMS)
        if due and (report := self._reception.report(now)):
            refresh = self.receive is not None and self.receive.refresh_needed
            acks.append(OutgoingBody(encode_body(messages.Feedback(report, refresh))))
        if self._portrait_ack is None and self.receive and (ack := self.receive.next_portrait_ack(now)):
            self._portrait_ack = OutgoingBody(encode_body(messages.PortraitAck(ack)))
        return [*acks, self._portrait_ack] if self._portrait_ack else acks

    def _report_due(self, now: float) -> bool:
        interval_s = self.send.report_interval_s(now) if self.send else REPORT_INTERVAL_S
        return self._reception.report_due(now, interval_s=interval_s)

    def _must_send_acks(self, now: float) -> bool:
        """Return whether the acknowledgements that are due are sent although nothing else is."""
        if not self._portrait_ack and not self._report_due(now):
            self._waiting_since = None
            return False
        if self._waiting_since is None:
            self._waiting_since = now
            self._wait_s = self.send.ride_wait(now) if self.send else 0.0
        return now >= self._waiting_since + self._wait_s

    def _on_acks_sent(self, acks: Sequence[OutgoingBody], now: float) -> None:
        self._waiting_since = self._portrait_ack = None
        if any(ack.kind in (REPORT, REFRESH_REPORT) for ack in acks):
            self._reception.on_reported(now)
            if self.receive:
                self.receive.refresh_needed = False

    def _datagrams(self, acks: Sequence[OutgoingBody], bodies: Sequence[OutgoingBody]) -> list[list[OutgoingBody]]:
        """Return the bodies of each datagram, the acknowledgements in the first."""
        return group_bodies([*acks, *bodies])

    def _within_limit(self, bodies: list[OutgoingBody], now: float) -> OutgoingBody | None:
        """Return a datagram's body with as many of its parts as the limit allows, and count it."""
        if not self.send:
            return join_outgoing(bodies)
        has_voice = any(body.kind in (VOICE_BIT, VOICE_STATE) for body in bodies)  # a state stands in for a packet
        consume = self.send.budget.consume_voice if has_voice else self.send.budget.consume
        for dropped in _DROPPED:
            kept = [body for body in bodies if body.kind not in dropped]
            if not kept:
                return None
            outgoing = join_outgoing(kept)
            if consume(HEADER_BYTES + self._sealed_bytes(len(outgoing.body)), now):
                return outgoing
        return None
