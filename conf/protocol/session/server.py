"""The receiver's side: many sessions over one socket, told apart by the number in each datagram. No I/O, no clock."""

from collections import Counter, deque
from collections.abc import Callable, Sequence

from conf.protocol.address import Address
from conf.protocol.rate_control.rate_limit import TokenBucket
from conf.protocol.session import events
from conf.protocol.session.active_session import ActiveSession, ClosedSession, SealedDatagram
from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.events import Event, LossReason
from conf.protocol.session.handshake import RandomBytes, Refusal
from conf.protocol.session.packet import (
    MAX_SESSION,
    DataPacket,
    HandshakePacket,
    Kind,
    handshake_datagram,
    parse_datagram,
)
from conf.protocol.session.responder import Attempt, Refuse, Responder
from conf.protocol.session.seal import EPOCH_LENGTH, CounterExhausted

MAX_SESSIONS = 9
IDLE_S = 30.0
UNKNOWN_REPLIES_PER_SECOND = 10.0
LINGER_S = 10.0  # for which the datagrams of a closed session are known; a peer in the dark calls again after 4 s


class SessionServer:
    """All sessions of one receiver.

    code : as normalise_code returns it; it stays valid for every sender while the receiver runs
    random : n -> n random bytes
    dropped : datagrams dropped, by reason
    """

    def __init__(
        self,
        code: str,
        random: RandomBytes,
        *,
        max_sessions: int = MAX_SESSIONS,
        epoch_length: int = EPOCH_LENGTH,
        refuse: Refuse | None = None,
        admit: Callable[[Attempt], None] | None = None,
    ) -> None:
        """refuse : why a caller at an address is refused, None for FULL if all sessions are in use

        admit : called with an attempt whose proof was right; raises DatagramError to disregard it
        """
        if not 1 <= max_sessions <= MAX_SESSION:
            raise ValueError(f"max_sessions must be from 1 to {MAX_SESSION}")
        self.dropped: Counter[DropReason] = Counter()
        self.sessions: dict[int, ActiveSession] = {}
        self._max_sessions = max_sessions
        self._epoch_length = epoch_length
        self._random = random
        self._responder = Responder(code, random, refuse=refuse or self._refuse, accept=self._accept)
        self._admit = admit
        self._unknown_replies = TokenBucket(UNKNOWN_REPLIES_PER_SECOND, UNKNOWN_REPLIES_PER_SECOND)
        self._next_session = random(1)[0] % (MAX_SESSION + 1)
        self._events: deque[Event] = deque()
        self._pending: list[tuple[bytes, Address]] = []
        self._candidates: tuple[Address, ...] = ()
        self._closed: dict[int, ClosedSession] = {}  # for LINGER_S

    def receive_datagram(self, data: bytes, address: Address, now: float) -> None:
        """Process a datagram, whatever its bytes: at worst it is counted in `dropped`."""
        try:
            packet = parse_datagram(data)
            if isinstance(packet, DataPacket):
                self._receive_data(packet, address, now)
            else:
                self._receive_handshake(packet, address, now)
        except DatagramError as error:
            self.dropped[error.reason] += 1

    def seal_body(self, session: int, body: bytes) -> SealedDatagram | None:
        """Return the datagram that carries `body` to the sender of `session`; None if the session has ended."""
        peer = self.sessions.get(session)
        if peer is None:
            return None
        try:
            return peer.seal(body)
        except CounterExhausted:
            self._drop(session, LossReason.EXHAUSTED)
            return None

    def sealed_bytes(self, session: int, body_bytes: int) -> int:
        """Return the size of the next datagram of a session with a body of `body_bytes`."""
        return self.sessions[session].sealing_key.sealed_bytes(body_bytes)

    def acknowledge(self, session: int, counter: int) -> None:
        """Note that the sender of a session has received our `counter`: counters need only one byte then."""
        if session in self.sessions:
            self.sessions[session].sealing_key.acknowledge(counter)

    def close(self, session: int, reason: LossReason = LossReason.CLOSED, *, farewell: bytes = b"") -> None:
        """End a session if it has not ended yet. farewell : as of ClosedSession"""
        if session in self.sessions:
            is_left = reason is LossReason.HUNG_UP
            self._closed[session] = ClosedSession(self.sessions[session], farewell=farewell, is_left=is_left)
            self._drop(session, reason)

    def is_leaving(self, now: float) -> bool:
        """Return whether the farewell of a closed session is being repeated."""
        return any(closed.is_leaving(now) for closed in self._closed.values())

    def datagrams_to_send(self, now: float) -> list[tuple[bytes, Address]]:
        """Return the datagrams of handshakes and of path validation, and end sessions that are silent for too long."""
        self._responder.expire(now)
        self._closed = {s: closed for s, closed in self._closed.items() if now < closed.last_received + LINGER_S}
        for session in [s for s, peer in self.sessions.items() if peer.last_received + IDLE_S <= now]:
            self._drop(session, LossReason.IDLE)
        pending, self._pending = self._pending, []
        for closed in self._closed.values():
            pending += closed.datagrams_to_send(now)
        for peer in self.sessions.values():
            datagrams, changes = peer.datagrams_to_send(now)
            pending += datagrams
            self._events += changes
        return pending

    @property
    def is_unheard(self) -> bool:
        """Whether a peer hears nothing of what this end sends over a relay."""
        return any(peer.paths.is_unheard for peer in self.sessions.values())

    def set_candidates(self, addresses: Sequence[Address]) -> None:
        """Announce the addresses at which this end may be reached directly, in sessions over a relay."""
        self._candidates = tuple(addresses)
        for peer in self.sessions.values():
            peer.paths.set_local(self._candidates)

    def next_event(self) -> Event | None:
        """Return the oldest event not returned yet."""
        return self._events.popleft() if self._events else None

    def _receive_data(self, packet: DataPacket, address: Address, now: float) -> None:
        peer = self.sessions.get(packet.session)
        if peer is None and (closed := self._closed.get(packet.session)):
            closed.receive(packet)
            return
        if peer is None:
            if self._unknown_replies.consume(1, now):
                self._pending.append((handshake_datagram(Kind.UNKNOWN, packet.session), address))
            raise DatagramError(DropReason.UNKNOWN_SESSION)
        self._events += peer.receive(packet, address, now)

    def _receive_handshake(self, packet: HandshakePacket, address: Address, now: float) -> None:
        if packet.kind is Kind.HELLO:
            self._pending.append((self._responder.hello(packet.fields, address, now), address))
        elif packet.kind is Kind.CONFIRM:
            answer, tries_left = self._responder.confirm(packet.fields, address, now)
            self._pending.append((answer, address))
            if tries_left is not None:
                self._events.append(events.WrongCode(tries_left, address))
        else:
            raise DatagramError(DropReason.DIRECTION)

    def _refuse(self, address: Address, now: float) -> tuple[Refusal, float] | None:
        others = sum(not peer.is_at(address) for peer in self.sessions.values())
        return None if others < self._max_sessions else (Refusal.FULL, 0.0)

    def _accept(self, attempt: Attempt, address: Address, now: float) -> int | None:
        if self._responder.refuse(address, now):
            return None
        if self._admit:
            self._admit(attempt)
        replaced = [s for s, peer in self.sessions.items() if peer.is_at(address) or self._max_sessions == 1]
        for session in replaced:
            self._drop(session, LossReason.REPLACED)
        while self._next_session in self.sessions:
            self._next_session = (self._next_session + 1) % (MAX_SESSION + 1)
        session = self._next_session
        self._next_session = (session + 1) % (MAX_SESSION + 1)
        both = attempt.secrets.from_receiver, attempt.secrets.from_sender
        self._closed.pop(session, None)
        self.sessions[session] = ActiveSession(
            session, both, address, now, random=self._random, epoch_length=self._epoch_length
        )
        self.sessions[session].paths.set_local(self._candidates)
        self._events.append(events.Connected(session, address))
        return session

    def _drop(self, session: int, reason: LossReason) -> None:
        del self.sessions[session]
        self._events.append(events.SessionEnded(session, reason))
