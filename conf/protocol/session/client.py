"""The sender's side: one session with one receiver, shaken hands again when the receiver seems gone. No I/O, no clock.

Strategy. A session is given up only for a better one. When nothing has been heard for a while, or the receiver says
that it does not know our session (which anybody could say), a new handshake starts beside the session. If the session
speaks again meanwhile the handshake is dropped; if the handshake succeeds it takes the session's place.
"""

from collections import Counter, deque
from dataclasses import dataclass

from conf.protocol.address import Address
from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.events import (
    BodyReceived,
    Connected,
    Event,
    LossReason,
    NoAnswer,
    Refused,
    SealedDatagram,
    SessionEnded,
    WrongCode,
)
from conf.protocol.session.handshake import RandomBytes, Refusal
from conf.protocol.session.initiator import HandshakeDone, HandshakeRefused, Initiator
from conf.protocol.session.packet import DataPacket, HandshakePacket, Kind, parse_datagram
from conf.protocol.session.seal import EPOCH_LENGTH, CounterExhausted, Opener, Sealer

IDLE_S = 30.0
SILENCE_S = 4.0  # a receiver reports twice a second: eight lost in a row is no longer chance
UNKNOWN_SESSION_SILENCE_S = 1.0
NO_ANSWER_S = 5.0
MIN_WAIT_S = 1.0
_TEMPORARY = {Refusal.LOCKED, Refusal.BUSY}


@dataclass
class ActiveSession:
    """The session as the sender has it."""

    session: int
    opener: Opener
    sealer: Sealer
    last_received: float


class SenderSession:
    """One sender's session with the receiver at `remote`.

    code : as normalise_code returns it
    random : n -> n random bytes
    dropped : datagrams dropped, by reason
    """

    def __init__(
        self, code: str, remote: Address, random: RandomBytes, now: float, *, epoch_length: int = EPOCH_LENGTH
    ) -> None:
        self.dropped: Counter[DropReason] = Counter()
        self._code = code
        self._remote = remote
        self._random = random
        self._epoch_length = epoch_length
        self._link: ActiveSession | None = None
        self._initiator: Initiator | None = Initiator(code, random, now)
        self._trying_since = now
        self._no_answer_reported = False
        self._stopped = False
        self._events: deque[Event] = deque()

    @property
    def session(self) -> int | None:
        """The number of the session, None while there is none."""
        return self._link.session if self._link else None

    @property
    def stopped(self) -> bool:
        """Whether the receiver refused for good: wrong code, or full."""
        return self._stopped

    def receive_datagram(self, data: bytes, address: Address, now: float) -> None:
        """Take a datagram, whatever its bytes: at worst it is counted in `dropped`."""
        try:
            packet = parse_datagram(data)
            if type(packet) is DataPacket:
                self._receive_data(packet, address, now)
            elif type(packet) is HandshakePacket:
                self._receive_handshake(packet, now)
        except DatagramError as error:
            self.dropped[error.reason] += 1

    def seal_body(self, body: bytes) -> SealedDatagram | None:
        """Return the datagram that carries `body` to the receiver; None while there is no session."""
        if self._link is None:
            return None
        counter = self._link.sealer.counter
        try:
            return SealedDatagram(self._link.sealer.seal(body), self._remote, counter)
        except CounterExhausted:
            self._lose(LossReason.EXHAUSTED)
            return None

    def acknowledge(self, counter: int) -> None:
        """Note that the receiver has received our `counter`: counters travel in one byte then."""
        if self._link:
            self._link.sealer.acknowledge(counter)

    def datagrams_to_send(self, now: float) -> list[tuple[bytes, Address]]:
        """Take what the handshake wants sent now."""
        self.handle_timer(now)
        datagram = self._initiator.datagram(now) if self._initiator else None
        return [] if datagram is None else [(datagram, self._remote)]

    def next_event(self) -> Event | None:
        """Take the next event, oldest first."""
        return self._events.popleft() if self._events else None

    def get_timer(self) -> float | None:
        """Return when handle_timer and then datagrams_to_send want to be called, None if never."""
        times = []
        if self._initiator:
            times.append(min(self._initiator.due, self._initiator.expires))
        if self._link:
            times.append(self._link.last_received + (IDLE_S if self._initiator or self._stopped else SILENCE_S))
        elif self._initiator and not self._no_answer_reported:
            times.append(self._trying_since + NO_ANSWER_S)
        return min(times, default=None)

    def handle_timer(self, now: float) -> None:
        """Notice silence: say so, shake hands again, give a dead session up."""
        if self._link and now >= self._link.last_received + IDLE_S:
            self._lose(LossReason.IDLE)
        if self._link is None or now >= self._link.last_received + SILENCE_S:
            self._try_again(now)
        if self._initiator and now >= self._initiator.expires:
            self._initiator = Initiator(self._code, self._random, now)
        waited = now - self._trying_since
        if self._initiator and not self._link and not self._no_answer_reported and waited >= NO_ANSWER_S:
            self._no_answer_reported = True
            self._events.append(NoAnswer(waited))

    def _receive_data(self, packet: DataPacket, address: Address, now: float) -> None:
        link = self._link
        if link is None or packet.session != link.session:
            raise DatagramError(DropReason.UNKNOWN_SESSION)
        counter, body = link.opener.open(packet)
        link.last_received = now
        if self._initiator and self._initiator.secrets is None:
            self._initiator = None
        self._events.append(BodyReceived(link.session, body, address, counter))

    def _receive_handshake(self, packet: HandshakePacket, now: float) -> None:
        if packet.kind is Kind.UNKNOWN:
            self._receive_hint(packet.fields[0], now)
            return
        if self._initiator is None:
            raise DatagramError(DropReason.UNKNOWN_ATTEMPT)
        result = self._initiator.receive(packet, now)
        self._trying_since = now
        if type(result) is HandshakeDone:
            self._connect(result, now)
        elif type(result) is HandshakeRefused:
            self._refuse(result, now)

    def _receive_hint(self, session: int, now: float) -> None:
        if self._link is None or session != self._link.session:
            raise DatagramError(DropReason.UNKNOWN_SESSION)
        if now >= self._link.last_received + UNKNOWN_SESSION_SILENCE_S:
            self._try_again(now)

    def _connect(self, result: HandshakeDone, now: float) -> None:
        if self._link:
            self._lose(LossReason.REPLACED)
        opener = Opener(result.secrets.from_receiver, epoch_length=self._epoch_length)
        sealer = Sealer(result.session, result.secrets.from_sender, epoch_length=self._epoch_length)
        self._link = ActiveSession(result.session, opener, sealer, now)
        self._initiator = None
        self._events.append(Connected(result.session, self._remote))

    def _refuse(self, result: HandshakeRefused, now: float) -> None:
        if result.refusal is Refusal.WRONG_CODE:
            self._events.append(WrongCode(result.number, self._remote))
        wait = max(result.number, MIN_WAIT_S) if result.refusal in _TEMPORARY else None
        if result.refusal is not Refusal.WRONG_CODE:
            self._events.append(Refused(result.refusal, wait))
        if wait is None or self._initiator is None:
            self._initiator, self._stopped = None, True
            return
        # Refusals are easily forged: one must not make us prove the code more often than CONFIRM_TIMEOUT_S allows.
        earliest = self._initiator.expires if self._initiator.secrets else now
        self._initiator = Initiator(self._code, self._random, max(now + wait, earliest))

    def _try_again(self, now: float) -> None:
        if self._initiator is None and not self._stopped:
            self._initiator = Initiator(self._code, self._random, now)
            self._trying_since = now
            self._no_answer_reported = False

    def _lose(self, reason: LossReason) -> None:
        assert self._link
        self._events.append(SessionEnded(self._link.session, reason))
        self._link = None
