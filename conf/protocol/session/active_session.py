"""A session on either side, established or just ended: both directions of the seal, and where the peer is."""

from dataclasses import dataclass

from conf.protocol.address import Address
from conf.protocol.session.events import AddressChanged, BodyReceived
from conf.protocol.session.handshake import RandomBytes
from conf.protocol.session.packet import DataPacket
from conf.protocol.session.paths.selection import PathSelection
from conf.protocol.session.seal import EPOCH_LENGTH, CounterExhausted, OpeningKey, SealingKey

LEAVING_S = 1.0  # for which a farewell is repeated that nobody answers
FAREWELL_INTERVAL_S = 0.15


@dataclass(frozen=True)
class SealedDatagram:
    """A datagram to send, its destination, and its counter, by which it will be acknowledged."""

    datagram: bytes
    address: Address
    counter: int


class ActiveSession:
    """A session with a peer.

    number : of the session; last_received : when a valid datagram came
    """

    def __init__(
        self,
        number: int,
        secrets: tuple[bytes, bytes],
        address: Address,
        now: float,
        *,
        random: RandomBytes,
        is_caller: bool = False,
        epoch_length: int = EPOCH_LENGTH,
    ) -> None:
        """secrets : of the bodies to seal and of those to open, 32 B each; random : n -> n random bytes

        address : at which the handshake was made; is_caller : whether this end began it
        """
        self.number = number
        self.sealing_key = SealingKey(number, secrets[0], epoch_length=epoch_length)
        self.opening_key = OpeningKey(secrets[1], epoch_length=epoch_length)
        self.last_received = now
        self.paths = PathSelection(address, now, random=random, is_caller=is_caller)
        self._reported = address

    @property
    def address(self) -> Address:
        """The peer's address on the path in use."""
        return self.paths.address

    def seal(self, body: bytes) -> SealedDatagram:
        """Return the datagram that carries `body` to the peer. Raises as SealingKey.seal."""
        counter = self.sealing_key.counter
        return SealedDatagram(self.sealing_key.seal(body), self.address, counter)

    def receive(self, packet: DataPacket, address: Address, now: float) -> list[AddressChanged | BodyReceived]:
        """Open a datagram that came from an address. Returns what has happened.

        Raises DatagramError, and changes nothing, if it was received before or is not authentic.
        """
        newest = self.opening_key.window.highest
        counter, body = self.opening_key.open(packet)
        self.last_received = now
        result: list[AddressChanged | BodyReceived] = [BodyReceived(self.number, body, address, counter)]
        self.paths.receive(body, address, now, is_newest=counter > newest)
        return [*self._address_changes(), *result]

    def datagrams_to_send(self, now: float) -> tuple[list[tuple[bytes, Address]], list[AddressChanged]]:
        """Return the datagrams that concern paths, and whether the path in use has changed."""
        bodies = self.paths.bodies_to_send(now)
        changes = self._address_changes()
        try:
            return [(self.sealing_key.seal(body), address) for body, address in bodies], changes
        except CounterExhausted:  # the next body of the call ends the session
            return [], changes

    def is_at(self, address: Address) -> bool:
        """Return whether an address is the peer's, on the path in use or on the relay."""
        return address in (self.paths.address, self.paths.relay)

    def _address_changes(self) -> list[AddressChanged]:
        if self.address == self._reported:
            return []
        self._reported = self.address
        return [AddressChanged(self.number, self.address)]


class ClosedSession:
    """A session that has ended at this end, whose last datagrams may still arrive.

    Strategy. Whoever leaves repeats its farewell until the peer answers with its own, at most for LEAVING_S. A peer
    that sends anything else later did not hear it, and gets it once more: else it would take the silence for an outage
    and call again. Whoever is left answers each farewell, and nothing else, so that answers never answer answers.
    """

    def __init__(self, session: ActiveSession, *, farewell: bytes = b"", is_left: bool = False) -> None:
        """farewell : body that tells the peer of the end, empty for none; is_left : the peer has ended the session"""
        self.number = session.number
        self.last_received = session.last_received
        self._session = session
        self._farewell = farewell
        self._is_left = is_left
        self._is_known = is_left or not farewell  # the end, to the peer
        self._is_due = is_left and bool(farewell)
        self._closed_at: float | None = None
        self._sent_at = float("-inf")

    def receive(self, packet: DataPacket) -> None:
        """Open a datagram. Raises DatagramError if it was received before or is not authentic."""
        _, body = self._session.opening_key.open(packet)
        if body == self._farewell and not self._is_left:
            self._is_known = True
        elif self._farewell and (body == self._farewell or not self._is_known):
            self._is_due = True

    def is_leaving(self, now: float) -> bool:
        """Return whether the farewell is being repeated."""
        return not self._is_known and (self._closed_at is None or now < self._closed_at + LEAVING_S)

    def datagrams_to_send(self, now: float) -> list[tuple[bytes, Address]]:
        """Return the farewell if it is due. That the owner sends one itself when it leaves is assumed."""
        if self._closed_at is None:
            self._closed_at = now
            self._sent_at = self._sent_at if self._is_left else now
        if not (self._is_due or self.is_leaving(now)) or now < self._sent_at + FAREWELL_INTERVAL_S:
            return []
        self._is_due, self._sent_at = False, now
        try:
            return [(self._session.sealing_key.seal(self._farewell), self._session.address)]
        except CounterExhausted:
            return []
