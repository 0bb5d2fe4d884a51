"""The receiver's end of all calls: the sessions and each sender's motion, in the shape of aioquic. No I/O, no clock."""

from collections import deque
from dataclasses import replace

from conf.protocol.address import Address
from conf.protocol.motion.inbound import InboundMotion
from conf.protocol.session.events import BodyReceived, Connected, Event, SessionEnded
from conf.protocol.session.server import SessionServer
from conf.protocol.statistics import HEADER_BYTES, TrafficSnapshot, merge_snapshots


class ReceiverEndpoint:
    """Everybody who calls this receiver. `inbounds` : the motion of each, by session."""

    def __init__(self, sessions: SessionServer) -> None:
        self.streams: dict[int, InboundMotion] = {}
        self._sessions = sessions
        self._events: deque[Event] = deque()
        self._calls = 0
        self._ended_totals: list[TrafficSnapshot] = []  # at most one: what all ended calls were together

    @property
    def rejected(self) -> int:
        """How many datagrams were dropped, for whatever reason."""
        return self._sessions.dropped.total() + sum(inbound.rejected for inbound in self.streams.values())

    def receive_datagram(self, data: bytes, address: Address, now: float) -> None:
        """Take a datagram, whatever its bytes: at worst it is counted."""
        self._sessions.receive_datagram(data, address, now)
        self._take_events(len(data) + HEADER_BYTES, now)

    def datagrams_to_send(self, now: float) -> list[tuple[bytes, Address]]:
        """Take the handshakes' answers and the reports that are due."""
        self._sessions.handle_timer(now)
        self._take_events(0, now)
        datagrams = self._sessions.datagrams_to_send(now)
        for session, inbound in self.streams.items():
            for body in inbound.bodies_to_send(now):
                if sealed := self._sessions.seal_body(session, body):
                    datagrams.append((sealed.datagram, sealed.address))
        return datagrams

    def snapshot(self, now: float) -> TrafficSnapshot:
        """Return the figures of all calls together, those that are over included."""
        running = [inbound.snapshot(now) for inbound in self.streams.values()]
        return replace(merge_snapshots([*self._ended_totals, *running]), rejected=self.rejected)

    def next_event(self) -> Event | None:
        """Take the next event, oldest first."""
        return self._events.popleft() if self._events else None

    def _take_events(self, wire_bytes: int, now: float) -> None:
        """Carry out what the sessions tell. wire_bytes : of the datagram that a body came in"""
        while event := self._sessions.next_event():
            match event:
                case BodyReceived(session=session, body=body, counter=counter):
                    self._take(session, body, counter, wire_bytes, now)
                case Connected(session=session):
                    self._calls += 1
                    self.streams[session] = InboundMotion(receiver_id=self._calls)
                    self._events.append(event)
                case SessionEnded(session=session):
                    self._end(session, now)
                    self._events.append(event)
                case _:
                    self._events.append(event)

    def _take(self, session: int, body: bytes, counter: int, wire_bytes: int, now: float) -> None:
        inbound = self.streams[session]
        inbound.receive_body(body, counter, wire_bytes, now)
        if inbound.ended:
            self._sessions.close(session)

    def _end(self, session: int, now: float) -> None:
        inbound = self.streams.pop(session, None)
        if inbound:
            ended = replace(inbound.snapshot(now), wire_kbps=0.0, fps=0.0)
            self._ended_totals = [merge_snapshots([*self._ended_totals, ended])]
