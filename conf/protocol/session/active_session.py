"""An established session on either side: both directions of the seal, and where the peer is."""

from dataclasses import dataclass

from conf.protocol.address import Address
from conf.protocol.session.events import AddressChanged, BodyReceived
from conf.protocol.session.handshake import RandomBytes
from conf.protocol.session.packet import DataPacket
from conf.protocol.session.paths.selection import PathSelection
from conf.protocol.session.seal import EPOCH_LENGTH, CounterExhausted, OpeningKey, SealingKey


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
