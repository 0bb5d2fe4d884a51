"""An established session on either side: both directions of the seal, and where the peer is."""

from dataclasses import dataclass

from conf.protocol.address import Address
from conf.protocol.session.events import AddressChanged, BodyReceived
from conf.protocol.session.handshake import RandomBytes
from conf.protocol.session.packet import DataPacket
from conf.protocol.session.path_validation import PathValidation
from conf.protocol.session.seal import EPOCH_LENGTH, CounterExhausted, OpeningKey, SealingKey


@dataclass(frozen=True)
class SealedDatagram:
    """A datagram to send, its destination, and its counter, by which it will be acknowledged."""

    datagram: bytes
    address: Address
    counter: int


class ActiveSession:
    """A session with a peer at `address`.

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
        epoch_length: int = EPOCH_LENGTH,
    ) -> None:
        """secrets : of the bodies to seal and of those to open, 32 B each; random : n -> n random bytes"""
        self.number = number
        self.sealing_key = SealingKey(number, secrets[0], epoch_length=epoch_length)
        self.opening_key = OpeningKey(secrets[1], epoch_length=epoch_length)
        self.address = address
        self.last_received = now
        self._paths = PathValidation(random)
        self._path_bodies: list[tuple[bytes, Address]] = []  # probes and answers to send

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
        if answer := self._paths.answer_to(body, now):
            self._path_bodies.append((answer, address))
        validated = self._paths.validated_by(body, now)
        if validated and validated != self.address:
            self.address = validated
            result.insert(0, AddressChanged(self.number, validated))
        # A datagram that arrives late says nothing about where the peer is now.
        if address != self.address and counter > newest and (probe := self._paths.probe(address, now)):
            self._path_bodies.append((probe, address))
        return result

    def datagrams_to_send(self) -> list[tuple[bytes, Address]]:
        """Return the probes of new addresses, and the answers to the peer's."""
        bodies, self._path_bodies = self._path_bodies, []
        try:
            return [(self.sealing_key.seal(body), address) for body, address in bodies]
        except CounterExhausted:  # the next body of the call ends the session
            return []
