"""Exchange datagrams between a transport and one end of a call: the part that all loops have in common."""

from collections.abc import Callable, Sequence, Set
from contextlib import AbstractContextManager, nullcontext
from typing import Protocol

from conf.errors import NetworkError
from conf.protocol.address import Address
from conf.transport.fault_tolerance import NETWORK_LIMIT_S, FaultTolerance
from conf.transport.interface import ReceivedDatagram, Transport

RECEIVE_BATCH = 512  # datagrams in one step: a few milliseconds of junk


class DatagramEndpoint(Protocol):
    """One end of a call, or of several, without I/O.

    is_unheard : whether a peer hears nothing of what this end sends over a relay
    """

    @property
    def is_unheard(self) -> bool: ...
    def receive_datagram(self, data: bytes, address: Address, now: float, /) -> None: ...
    def datagrams_to_send(self, now: float, /) -> list[tuple[bytes, Address]]: ...
    def set_candidates(self, addresses: Sequence[Address], /) -> None: ...


class DatagramExchange:
    """Carries datagrams, and survives failures of the network for 10 s.

    What cannot be sent to anybody but the peers ends no call: the source of what is answered may be forged.
    """

    def __init__(
        self,
        socket: Transport,
        endpoint: DatagramEndpoint,
        *,
        peers: Callable[[], Set[Address]] | None = None,
        lock: AbstractContextManager[object] | None = None,
    ) -> None:
        """Connect a transport with an endpoint.

        peers : the addresses of those in a call, where strangers are answered too; None if there is but one peer
        lock : held while datagrams change the endpoint's streams
        """
        self._refused = ""
        self._candidates: Sequence[Address] = ()
        self._socket = socket
        self._endpoint = endpoint
        self._peers = peers
        self._lock = lock or nullcontext()
        # A listening socket is bound: what fails from now on may pass.
        self._sending, self._receiving = (FaultTolerance(NETWORK_LIMIT_S, has_worked=peers is not None) for _ in "sr")

    @property
    def note(self) -> str:
        """What to tell the user while the network fails, "" otherwise."""
        return self._sending.note or self._receiving.note

    def receive(self, now: float) -> bool:
        """Process the datagrams that have arrived. Returns whether it was a full batch, of which there may be more.

        Raises NetworkError if receiving has failed for too long.
        """
        try:
            datagrams: list[ReceivedDatagram] = self._socket.receive(RECEIVE_BATCH)
        except NetworkError as error:
            self._receiving.on_failure(error, now)
            return False
        self._receiving.on_success()
        with self._lock:
            for data, address, queued_s in datagrams:
                self._endpoint.receive_datagram(data, address, now - queued_s)
        return len(datagrams) == RECEIVE_BATCH

    def send(self, now: float) -> None:
        """Send what is due. Raises NetworkError if that has failed for too long."""
        with self._lock:
            if (candidates := self._socket.candidates) != self._candidates:
                self._endpoint.set_candidates(candidates)
                self._candidates = candidates
            datagrams = self._endpoint.datagrams_to_send(now)
            if self._endpoint.is_unheard:
                self._socket.renew()
        peers = None if self._peers is None else self._peers()
        is_to_peer = bool(datagrams) if peers is None else any(address in peers for _, address in datagrams)
        try:
            self._socket.send(datagrams)
        except NetworkError as error:
            if is_to_peer:
                self._sending.on_failure(error, now)
            else:
                self._refused = str(error)
        else:
            if is_to_peer or peers == set():
                self._sending.on_success()

    def pop_refused(self) -> str:
        """Return why nothing could be sent to a stranger since the last call, "" if that did not happen."""
        text, self._refused = self._refused, ""
        return text
