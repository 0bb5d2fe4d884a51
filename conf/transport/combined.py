"""UDP and a relay as one transport: what is addressed to a peer behind the relay goes there, all else over UDP."""

import select
import time
from collections.abc import Callable
from typing import Self

from conf.errors import NetworkError
from conf.protocol.address import Address, RelayAddress
from conf.transport.interface import HasFileno, ReceivedDatagram, SelectableTransport
from conf.transport.stun import StunClient


class CombinedTransport:
    """Two transports as one.

    stun : asks for the outside address of the UDP socket; may be set at any time
    """

    def __init__(
        self,
        udp: SelectableTransport,
        relay: SelectableTransport,
        *,
        stun: StunClient | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """udp, relay : are closed with it"""
        self.stun = stun
        self._udp = udp
        self._relay = relay
        self._clock = clock

    @property
    def remote(self) -> Address | None:
        """Whom the relay calls, None if this end waits to be called."""
        return self._relay.remote

    @property
    def address(self) -> Address:
        """The first local host and port."""
        return self._udp.address

    @property
    def handles(self) -> list[HasFileno]:
        """What becomes readable when a datagram has arrived."""
        return [*self._udp.handles, *self._relay.handles]

    @property
    def candidates(self) -> tuple[Address, ...]:
        """No addresses."""
        return ()

    @property
    def nameplate(self) -> str:
        """The number under which the ends find each other on the relay."""
        return self._relay.nameplate

    @property
    def others_wait(self) -> bool:
        """Whether another end waits with the nameplate, as far as known."""
        return self._relay.others_wait

    def path_name(self, address: Address, /) -> str:
        """Return how datagrams reach an address."""
        return (self._relay if isinstance(address, RelayAddress) else self._udp).path_name(address)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def receive(self, limit: int, /) -> list[ReceivedDatagram]:
        """Return the datagrams that have arrived, without answers of STUN servers, at most `limit` a way in.

        Raises NetworkError if there are none because this machine cannot receive.
        """
        datagrams, failures = [], []
        for transport in (self._udp, self._relay):
            try:
                datagrams += transport.receive(limit)
            except NetworkError as error:
                failures.append(error)
        if failures and not datagrams:
            raise failures[0]
        if stun := self.stun:
            return [item for item in datagrams if not stun.receive_datagram(item.data, item.address)]
        return datagrams

    def send(self, datagrams: list[tuple[bytes, Address]], /) -> None:
        """Send datagrams, and requests to STUN servers that are due.

        Raises NetworkError, after all were tried, if none could be sent.
        """
        ways = {
            self._relay: [item for item in datagrams if isinstance(item[1], RelayAddress)],
            self._udp: [item for item in datagrams if not isinstance(item[1], RelayAddress)],
        }
        failures = []
        for transport, items in ways.items():
            try:
                if items:
                    transport.send(items)
            except NetworkError as error:
                failures.append(error)
        self._ask_stun_servers()
        if failures and len(failures) == sum(map(bool, ways.values())):
            raise failures[0]

    def wait(self, seconds: float, /) -> None:
        """Sleep until a datagram arrives, at most `seconds`."""
        select.select(self.handles, [], [], max(seconds, 0.0))

    def renew(self) -> None:
        """Reach the relay in another way."""
        self._relay.renew()

    def close(self) -> None:
        """Close both transports."""
        self._udp.close()
        self._relay.close()

    def _ask_stun_servers(self) -> None:
        if self.stun is None:
            return
        for request in self.stun.datagrams_to_send(self._clock()):
            try:
                self._udp.send([request])
            except NetworkError:  # without an answer there is no outside address, which is no fault of the call
                continue
