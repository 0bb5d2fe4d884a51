"""One session with one peer, whoever of the two calls. Sans-IO.

Strategy. A SessionServer of one session answers, and a SenderSession calls if there is somebody to call. At most one of
them has a session. If both ends call each other at once (glare), both handshakes go on until a proof decides: an end
disregards the peer's proof as long as its own handshake has been answered and has the larger `attempt`. Otherwise it
accepts the proof and drops its own handshake. Nothing is decided before a proof, so a stranger cannot stop a call. An
end that is not called back cannot be reached by its own hello; then the peer's proof is accepted whatever its attempt.

The session in use has priority. A third caller is refused while the peer is heard. A peer that has restarted is the
same as a third caller until the old session has been silent for SILENCE_S, and then replaces it; from another host only
after OTHER_HOST_SILENCE_S, as a busy machine may stop its program for seconds.
"""

from collections import Counter, deque
from collections.abc import Sequence

from conf.protocol.address import Address, host_of
from conf.protocol.session.active_session import ActiveSession, SealedDatagram
from conf.protocol.session.client import SILENCE_S, SenderSession
from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.events import Connected, Event, LossReason
from conf.protocol.session.handshake import RandomBytes, Refusal
from conf.protocol.session.packet import DATA_PREFIX, HANDSHAKE_PREFIX, MAX_OVERHEAD, Kind
from conf.protocol.session.responder import Attempt
from conf.protocol.session.seal import EPOCH_LENGTH
from conf.protocol.session.server import SessionServer

OTHER_HOST_SILENCE_S = 10.0
_ANSWERS = {Kind.RETRY, Kind.ANSWER, Kind.DONE, Kind.REFUSED, Kind.UNKNOWN}


class CallSession:
    """The session of a call of two.

    code : as normalise_code returns it; random : n -> n random bytes
    """

    def __init__(
        self,
        code: str,
        random: RandomBytes,
        now: float,
        *,
        remote: Address | None = None,
        epoch_length: int = EPOCH_LENGTH,
    ) -> None:
        """remote : whom to call, None to wait to be called"""
        self._server = SessionServer(
            code, random, max_sessions=1, epoch_length=epoch_length, refuse=self._refuse, admit=self._admit
        )
        self._caller = SenderSession(code, remote, random, now, epoch_length=epoch_length) if remote else None
        self._connected_at = float("-inf")  # the caller's session
        self._events: deque[Event] = deque()

    @property
    def session(self) -> int | None:
        """The number of the session, None while there is none."""
        active = self._active
        return active.number if active else None

    @property
    def peer(self) -> Address | None:
        """The peer's address, None while there is no session."""
        active = self._active
        return active.address if active else None

    @property
    def dropped(self) -> Counter[DropReason]:
        """Datagrams dropped, by reason."""
        return self._server.dropped + (self._caller.dropped if self._caller else Counter())

    def receive_datagram(self, data: bytes, address: Address, now: float) -> None:
        """Process a datagram, whatever its bytes: at worst it is counted in `dropped`."""
        if self._caller and self._is_for_caller(data):
            self._caller.receive_datagram(data, address, now)
        else:
            self._server.receive_datagram(data, address, now)
        self._collect_events(now)

    def datagrams_to_send(self, now: float) -> list[tuple[bytes, Address]]:
        """Return the datagrams of handshakes that are due, and end a session that has been silent too long."""
        datagrams = self._server.datagrams_to_send(now)
        if self._caller:
            if self._is_called(now):
                self._caller.drop_unanswered_handshake()
            if not self._is_called(now) or self._caller.initiator:
                datagrams += self._caller.datagrams_to_send(now)
        self._collect_events(now)
        return datagrams

    @property
    def is_unheard(self) -> bool:
        """Whether the peer hears nothing of what this end sends over a relay."""
        return self._server.is_unheard or (self._caller is not None and self._caller.is_unheard)

    def set_candidates(self, addresses: Sequence[Address]) -> None:
        """Announce the addresses at which this end may be reached directly, in a session over a relay."""
        self._server.set_candidates(addresses)
        if self._caller:
            self._caller.set_candidates(addresses)

    def seal_body(self, body: bytes) -> SealedDatagram | None:
        """Return the datagram that carries `body` to the peer; None while there is no session."""
        for number in self._server.sessions:
            return self._server.seal_body(number, body)
        return self._caller.seal_body(body) if self._caller else None

    def sealed_bytes(self, body_bytes: int) -> int:
        """Return the size of the next datagram with a body of `body_bytes`; without a session the largest."""
        active = self._active
        return active.sealing_key.sealed_bytes(body_bytes) if active else body_bytes + MAX_OVERHEAD

    def acknowledge(self, counter: int) -> None:
        """Note that the peer has received our `counter`: counters need only one byte then."""
        if active := self._active:
            active.sealing_key.acknowledge(counter)

    def close(self, reason: LossReason = LossReason.CLOSED, *, farewell: bytes = b"") -> None:
        """End the session, and call no more. An end that waits to be called continues to wait.

        farewell : as of ClosedSession
        """
        for number in list(self._server.sessions):
            self._server.close(number, reason, farewell=farewell)
        if self._caller:
            self._caller.close(reason, farewell=farewell)

    def is_leaving(self, now: float) -> bool:
        """Return whether the farewell of a closed session is being repeated."""
        return self._server.is_leaving(now) or (self._caller is not None and self._caller.is_leaving(now))

    def next_event(self) -> Event | None:
        """Return the oldest event not returned yet."""
        self._collect_events(self._connected_at)
        return self._events.popleft() if self._events else None

    @property
    def _active(self) -> ActiveSession | None:
        return next(iter(self._server.sessions.values()), None) or (self._caller.active if self._caller else None)

    def _is_for_caller(self, data: bytes) -> bool:
        """Return whether a datagram, which may be malformed, answers our calls."""
        assert self._caller
        first, third = data[:1], data[2:3]
        if first == bytes((HANDSHAKE_PREFIX,)):
            return bool(third) and third[0] in _ANSWERS
        return first == bytes((DATA_PREFIX,)) and bool(third) and self._caller.has_session(third[0])

    def _is_called(self, now: float) -> bool:
        """Return whether the peer has called and is heard."""
        return any(now < peer.last_received + SILENCE_S for peer in self._server.sessions.values())

    def _refuse(self, address: Address, now: float) -> tuple[Refusal, float] | None:
        active = self._active
        if active is None or active.is_at(address):
            return None
        silence_s = SILENCE_S if host_of(active.address) == host_of(address) else OTHER_HOST_SILENCE_S
        wait_s = active.last_received + silence_s - now
        return (Refusal.IN_CALL, max(wait_s, 1.0)) if wait_s > 0 else None

    def _admit(self, attempt: Attempt) -> None:
        """Raise DatagramError for the proof of a call that has crossed ours, if ours goes on."""
        if self._caller is None:
            return
        ours = self._caller.initiator
        goes_on = ours is not None and ours.secrets is not None and ours.attempt > attempt.name
        if goes_on or (self._caller.active and attempt.begun <= self._connected_at):
            raise DatagramError(DropReason.GLARE)

    def _collect_events(self, now: float) -> None:
        """Queue the events of both; a new session of one ends that of the other."""
        while event := self._server.next_event():
            if isinstance(event, Connected) and self._caller:
                self._caller.withdraw(LossReason.REPLACED)
                self._events += iter(self._caller.next_event, None)
            self._events.append(event)
        while self._caller and (event := self._caller.next_event()):
            if isinstance(event, Connected):
                self._connected_at = now
                for number in list(self._server.sessions):
                    self._server.close(number, LossReason.REPLACED)
                self._events += iter(self._server.next_event, None)
            self._events.append(event)
