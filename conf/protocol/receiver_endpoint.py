"""The side of all calls that is called: its sessions and a leg for each. No I/O, no clock."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from conf.protocol.address import Address
from conf.protocol.call_leg import CallLeg
from conf.protocol.call_report import CallLog, CallReport
from conf.protocol.receive_leg import ReceiveLeg
from conf.protocol.session.events import AddressChanged, BodyReceived, Connected, Event, LossReason, SessionEnded
from conf.protocol.session.server import SessionServer
from conf.protocol.statistics import HEADER_BYTES, TrafficSnapshot, merge_snapshots


class ReceiverEndpoint:
    """Receive from all who call.

    streams : the receiving half of each call, by session number
    ended_calls : number of calls that have ended
    """

    def __init__(self, sessions: SessionServer) -> None:
        self.streams: dict[int, ReceiveLeg] = {}
        self._legs: dict[int, CallLeg] = {}
        self._sessions = sessions
        self._events: deque[Event] = deque()
        self.ended_calls = 0
        self._calls = 0
        self._ended_rejected = 0
        self._log = CallLog()

    @property
    def rejected(self) -> int:
        """Number of datagrams dropped, for whatever reason."""
        running = sum(leg.rejected for leg in self.streams.values())
        return self._sessions.dropped.total() + self._ended_rejected + running

    @property
    def callers(self) -> set[Address]:
        """The addresses of all callers."""
        return {peer.address for peer in self._sessions.sessions.values()}

    @property
    def addresses(self) -> dict[int, Address]:
        """The address of each caller, by session number."""
        return {session: peer.address for session, peer in self._sessions.sessions.items()}

    def receive_datagram(self, data: bytes, address: Address, now: float) -> None:
        """Process a datagram, whatever its bytes: at worst it is counted."""
        self._sessions.receive_datagram(data, address, now)
        self._process_events(len(data) + HEADER_BYTES, now)

    def datagrams_to_send(self, now: float) -> list[tuple[bytes, Address]]:
        """Return the datagrams to send now: handshake answers, reports and acknowledgements."""
        datagrams = self._sessions.datagrams_to_send(now)
        self._process_events(0, now)
        for session, leg in self._legs.items():
            for outgoing in leg.bodies_to_send(now):
                if sealed := self._sessions.seal_body(session, outgoing.body):
                    leg.on_sent(sealed.counter, outgoing, now)
                    datagrams.append((sealed.datagram, sealed.address))
        return datagrams

    @property
    def is_unheard(self) -> bool:
        """Whether a peer hears nothing of what this end sends over a relay."""
        return self._sessions.is_unheard

    def set_candidates(self, addresses: Sequence[Address]) -> None:
        """Announce the addresses at which this end may be reached directly, in sessions over a relay."""
        self._sessions.set_candidates(addresses)

    def snapshot(self, now: float) -> TrafficSnapshot:
        """Return the traffic figures of the present callers together.

        A caller that is silent counts with its frames and bytes, but has no rate, jitter or delay.
        """
        figures = (
            replace(leg.snapshot(now), raw_kbps=0.0, jitter_ms=0.0, playout_delay_ms=0.0)
            if leg.is_silent(now)
            else leg.snapshot(now)
            for leg in self.streams.values()
        )
        return replace(merge_snapshots(list(figures)), rejected=self.rejected)

    def report(self, now: float, *, path_name: Callable[[Address], str] | None = None) -> CallReport:
        """Return the figures of all calls so far, ended ones included. path_name : how an address is reached"""
        running = {session: leg.snapshot(now) for session, leg in self.streams.items()}
        return replace(self._log.report(running, now, path_name=path_name), rejected=self.rejected)

    def next_event(self) -> Event | None:
        """Return the oldest event not returned yet."""
        return self._events.popleft() if self._events else None

    def _process_events(self, wire_bytes: int, now: float) -> None:
        """Apply the sessions' events. wire_bytes : of the datagram in which a body arrived"""
        while event := self._sessions.next_event():
            match event:
                case BodyReceived(session=session, body=body, counter=counter):
                    self._receive_body(session, body, counter, wire_bytes, now)
                    continue
                case Connected(session=session, address=address):
                    self._begin(session)
                    self._log.on_connected(session, address, now)
                case AddressChanged(session=session, address=address):
                    self._log.on_address_changed(session, address)
                case SessionEnded(session=session, reason=reason):
                    self._end(session, reason, now)
            self._events.append(event)

    def _receive_body(self, session: int, body: bytes, counter: int, wire_bytes: int, now: float) -> None:
        leg = self._legs[session]
        if (acknowledged := leg.receive_body(body, counter, wire_bytes, now)) is not None:
            self._sessions.acknowledge(session, acknowledged)
        if leg.ended:
            self._sessions.close(session)

    def _begin(self, session: int) -> None:
        self._calls += 1
        self.streams[session] = ReceiveLeg(receiver_id=self._calls)
        sealed_bytes = partial(self._sessions.sealed_bytes, session)
        self._legs[session] = CallLeg(receive=self.streams[session], sealed_bytes=sealed_bytes)

    def _end(self, session: int, reason: LossReason, now: float) -> None:
        leg = self.streams.pop(session)
        del self._legs[session]
        was_there = leg.last_received if reason is LossReason.IDLE else now
        self._log.on_ended(session, leg.snapshot(now), now if was_there is None else was_there)
        self._ended_rejected += leg.rejected
        self.ended_calls += 1
