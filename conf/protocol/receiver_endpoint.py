"""The receiver's side of all calls: its sessions and a receiving half for each. No I/O, no clock."""

from collections import deque
from dataclasses import replace

from conf.protocol.address import Address
from conf.protocol.receive_leg import ReceiveLeg
from conf.protocol.session.events import BodyReceived, Connected, Event, SessionEnded
from conf.protocol.session.server import SessionServer
from conf.protocol.statistics import HEADER_BYTES, TrafficSnapshot, merge_snapshots


class ReceiverEndpoint:
    """Receive from all senders that call. `streams` : the receiving half of each call, by session number."""

    def __init__(self, sessions: SessionServer) -> None:
        self.streams: dict[int, ReceiveLeg] = {}
        self._sessions = sessions
        self._events: deque[Event] = deque()
        self._calls = 0
        self._ended_totals: list[TrafficSnapshot] = []  # at most one: all ended calls together

    @property
    def rejected(self) -> int:
        """Number of datagrams dropped, for whatever reason."""
        return self._sessions.dropped.total() + sum(leg.rejected for leg in self.streams.values())

    def receive_datagram(self, data: bytes, address: Address, now: float) -> None:
        """Process a datagram, whatever its bytes: at worst it is counted."""
        self._sessions.receive_datagram(data, address, now)
        self._process_events(len(data) + HEADER_BYTES, now)

    def datagrams_to_send(self, now: float) -> list[tuple[bytes, Address]]:
        """Return the datagrams to send now: handshake answers, reports and acknowledgements."""
        datagrams = self._sessions.datagrams_to_send(now)
        self._process_events(0, now)
        for session, leg in self.streams.items():
            for body in leg.bodies_to_send(now):
                if sealed := self._sessions.seal_body(session, body):
                    datagrams.append((sealed.datagram, sealed.address))
        return datagrams

    def snapshot(self, now: float) -> TrafficSnapshot:
        """Return the traffic figures of all calls together, ended ones included."""
        running = [leg.snapshot(now) for leg in self.streams.values()]
        return replace(merge_snapshots([*self._ended_totals, *running]), rejected=self.rejected)

    def next_event(self) -> Event | None:
        """Return the oldest event not returned yet."""
        return self._events.popleft() if self._events else None

    def _process_events(self, wire_bytes: int, now: float) -> None:
        """Apply the sessions' events. wire_bytes : of the datagram in which a body arrived"""
        while event := self._sessions.next_event():
            match event:
                case BodyReceived(session=session, body=body, counter=counter):
                    leg = self.streams[session]
                    leg.receive_body(body, counter, wire_bytes, now)
                    if leg.ended:
                        self._sessions.close(session)
                    continue
                case Connected(session=session):
                    self._calls += 1
                    self.streams[session] = ReceiveLeg(receiver_id=self._calls)
                case SessionEnded(session=session):
                    totals = replace(self.streams.pop(session).snapshot(now), wire_kbps=0.0, fps=0.0)
                    self._ended_totals = [merge_snapshots([*self._ended_totals, totals])]
            self._events.append(event)
