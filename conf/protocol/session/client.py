"""The sender's side: one session with one receiver, renewed when the receiver seems gone. No I/O, no clock.

Strategy. A session is given up only for a better one. When nothing has been received for a while, or the receiver says
that it does not know our session (which anybody could say), a new handshake starts beside the session. If a datagram
of the session arrives meanwhile, the handshake is dropped; if the handshake succeeds, it replaces the session.
"""

from collections import Counter, deque
from collections.abc import Sequence

from conf.protocol.address import Address
from conf.protocol.session import events
from conf.protocol.session.active_session import ActiveSession, ClosedSession, SealedDatagram
from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.events import Event, LossReason
from conf.protocol.session.handshake import RandomBytes, Refusal
from conf.protocol.session.initiator import HandshakeDone, HandshakeRefused, Initiator
from conf.protocol.session.packet import MAX_OVERHEAD, DataPacket, HandshakePacket, Kind, parse_datagram
from conf.protocol.session.seal import EPOCH_LENGTH, CounterExhausted

IDLE_S = 30.0
SILENCE_S = 4.0  # a receiver reports twice a second: eight reports lost in a row are no chance
UNKNOWN_SESSION_SILENCE_S = 1.0
NO_ANSWER_S = 5.0
MIN_WAIT_S = 1.0
_TEMPORARY = {Refusal.LOCKED, Refusal.BUSY, Refusal.IN_CALL}


class SenderSession:
    """One sender's session with the receiver at `remote`.

    code : as normalise_code returns it
    random : n -> n random bytes
    dropped : datagrams dropped, by reason
    stopped : whether no more is tried: the receiver refused for good (wrong code, or full), or the session was closed
    """

    def __init__(
        self, code: str, remote: Address, random: RandomBytes, now: float, *, epoch_length: int = EPOCH_LENGTH
    ) -> None:
        self.dropped: Counter[DropReason] = Counter()
        self.stopped = False
        self._code = code
        self._remote = remote
        self._moved_to: Address | None = None  # the newest address of the receiver
        self._random = random
        self._epoch_length = epoch_length
        self._active: ActiveSession | None = None
        self._closed: ClosedSession | None = None
        self._initiator: Initiator | None = Initiator(code, random, now)
        self._trying_since = now
        self._no_answer_reported = False
        self._events: deque[Event] = deque()
        self._candidates: tuple[Address, ...] = ()

    @property
    def session(self) -> int | None:
        """The number of the session, None while there is none."""
        return self._active.number if self._active else None

    @property
    def active(self) -> ActiveSession | None:
        """The session, None while there is none."""
        return self._active

    @property
    def initiator(self) -> Initiator | None:
        """The handshake in progress, if any."""
        return self._initiator

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

    def seal_body(self, body: bytes) -> SealedDatagram | None:
        """Return the datagram that carries `body` to the receiver; None while there is no session."""
        if self._active is None:
            return None
        try:
            return self._active.seal(body)
        except CounterExhausted:
            self._end(LossReason.EXHAUSTED)
            return None

    def sealed_bytes(self, body_bytes: int) -> int:
        """Return the size of the next datagram with a body of `body_bytes`; without a session the largest."""
        return self._active.sealing_key.sealed_bytes(body_bytes) if self._active else body_bytes + MAX_OVERHEAD

    def acknowledge(self, counter: int) -> None:
        """Note that the receiver has received our `counter`: counters need only one byte then."""
        if self._active:
            self._active.sealing_key.acknowledge(counter)

    def withdraw(self, reason: LossReason) -> None:
        """End the session and the handshake in progress; another may begin."""
        self._initiator = None
        if self._active:
            self._end(reason)

    def close(self, reason: LossReason = LossReason.CLOSED, *, farewell: bytes = b"") -> None:
        """End the session and try no more. farewell : as of ClosedSession"""
        self.stopped = True
        if self._active:
            is_left = reason is LossReason.HUNG_UP
            self._closed = ClosedSession(self._active, farewell=farewell, is_left=is_left)
        self.withdraw(reason)

    def is_leaving(self, now: float) -> bool:
        """Return whether the farewell of the closed session is being repeated."""
        return self._closed is not None and self._closed.is_leaving(now)

    def has_session(self, number: int) -> bool:
        """Return whether the session has this number, or had it before it was closed."""
        return any(a is not None and a.number == number for a in (self._active, self._closed))

    def drop_unanswered_handshake(self) -> None:
        """Stop the handshake in progress unless the receiver has answered it."""
        if self._initiator and self._initiator.secrets is None:
            self._initiator = None

    def datagrams_to_send(self, now: float) -> list[tuple[bytes, Address]]:
        """Return the datagrams of the handshake and of path validation that are due.

        If the receiver has moved, the handshake is tried at its last address too.
        """
        self._handle_silence(now)
        self._moved_to = self._active.address if self._active else self._moved_to
        datagram = self._initiator.datagram(now) if self._initiator else None
        addresses = dict.fromkeys((self._remote, self._moved_to)) if datagram else {}
        handshake = [(datagram, address) for address in addresses if datagram and address]
        farewells = self._closed.datagrams_to_send(now) if self._closed else []
        return handshake + farewells + self._path_datagrams(now)

    @property
    def is_unheard(self) -> bool:
        """Whether the receiver hears nothing of what this end sends over a relay."""
        return self._active is not None and self._active.paths.is_unheard

    def set_candidates(self, addresses: Sequence[Address]) -> None:
        """Announce the addresses at which this end may be reached directly, in sessions over a relay."""
        self._candidates = tuple(addresses)
        if self._active:
            self._active.paths.set_local(self._candidates)

    def next_event(self) -> Event | None:
        """Return the oldest event not returned yet."""
        return self._events.popleft() if self._events else None

    def _path_datagrams(self, now: float) -> list[tuple[bytes, Address]]:
        if self._active is None:
            return []
        datagrams, changes = self._active.datagrams_to_send(now)
        self._events += changes
        return datagrams

    def _handle_silence(self, now: float) -> None:
        """Report silence, start a new handshake, end a dead session."""
        if self._active and now >= self._active.last_received + IDLE_S:
            self._end(LossReason.IDLE)
        if self._active is None or now >= self._active.last_received + SILENCE_S:
            self._start_handshake(now)
        if self._initiator and now >= self._initiator.expires:
            self._initiator = Initiator(self._code, self._random, now)
        waited = now - self._trying_since
        if self._initiator and not self._active and not self._no_answer_reported and waited >= NO_ANSWER_S:
            self._no_answer_reported = True
            self._events.append(events.NoAnswer(waited))

    def _receive_data(self, packet: DataPacket, address: Address, now: float) -> None:
        active = self._active
        if active is None and self._closed and self.has_session(packet.session):
            self._closed.receive(packet)
            return
        if active is None or packet.session != self.session:
            raise DatagramError(DropReason.UNKNOWN_SESSION)
        self._events += active.receive(packet, address, now)
        self.drop_unanswered_handshake()

    def _receive_handshake(self, packet: HandshakePacket, address: Address, now: float) -> None:
        if packet.kind is Kind.UNKNOWN:
            self._receive_unknown(packet.fields[0], now)
            return
        if self._initiator is None:
            raise DatagramError(DropReason.UNKNOWN_ATTEMPT)
        result = self._initiator.receive(packet, now)
        self._trying_since = now
        if type(result) is HandshakeDone:
            self._connect(result, address, now)
        elif type(result) is HandshakeRefused:
            self._on_refused(result, now)

    def _receive_unknown(self, session: int, now: float) -> None:
        if self._active is None or session != self.session:
            raise DatagramError(DropReason.UNKNOWN_SESSION)
        if now >= self._active.last_received + UNKNOWN_SESSION_SILENCE_S:
            self._start_handshake(now)

    def _connect(self, result: HandshakeDone, address: Address, now: float) -> None:
        if self._active:
            self._end(LossReason.REPLACED)
        # A copy of the answer may have come from anywhere.
        address = address if address == self._moved_to else self._remote
        secrets = result.secrets.from_sender, result.secrets.from_receiver
        self._active = ActiveSession(
            result.session, secrets, address, now, random=self._random, is_caller=True, epoch_length=self._epoch_length
        )
        self._active.paths.set_local(self._candidates)
        self._initiator, self._moved_to = None, address
        self._events.append(events.Connected(result.session, address))

    def _on_refused(self, result: HandshakeRefused, now: float) -> None:
        wait = max(float(result.number), MIN_WAIT_S) if result.refusal in _TEMPORARY else None
        if result.refusal is Refusal.WRONG_CODE:
            self._events.append(events.WrongCode(result.number, self._remote))
        else:
            self._events.append(events.Refused(result.refusal, wait))
        if wait is None or self._initiator is None:
            self._initiator, self.stopped = None, True
            return
        # Refusals are easily forged: one must not make us prove the code more often than CONFIRM_TIMEOUT_S allows.
        earliest = self._initiator.expires if self._initiator.secrets else now
        self._trying_since = max(now + wait, earliest)
        self._initiator = Initiator(self._code, self._random, self._trying_since)

    def _start_handshake(self, now: float) -> None:
        if self._initiator is None and not self.stopped:
            self._initiator = Initiator(self._code, self._random, now)
            self._trying_since = now
            self._no_answer_reported = False

    def _end(self, reason: LossReason) -> None:
        assert self._active
        self._events.append(events.SessionEnded(self._active.number, reason))
        self._moved_to = self._active.address
        self._active = None
