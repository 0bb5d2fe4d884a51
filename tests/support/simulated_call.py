"""Two ends of a call of two in memory: a network of which a test chooses what it does to each datagram."""

from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

from conf.protocol.address import Address
from conf.protocol.session.events import BodyReceived, Event
from tests.support.simulated_sessions import Delays, Network, at_once

A: Address = ("192.0.2.1", 5005)
B: Address = ("198.51.100.7", 40000)
STEP_S = 0.05


class End(Protocol):
    """What this network connects: CallSession, CallEndpoint."""

    def receive_datagram(self, data: bytes, address: Address, now: float, /) -> None: ...

    def datagrams_to_send(self, now: float, /) -> list[tuple[bytes, Address]]: ...

    def next_event(self) -> Event | None: ...


E = TypeVar("E", bound=End)


class Link(Generic[E]):
    """Ends at their addresses, and the datagrams between them.

    delays : what the network does to each datagram; unreachable : addresses at which nothing arrives
    forwards : address at which an end is still reached -> the address it has now
    events : of each end by name; sent : (time, source, target, data) of all datagrams
    tick : called with the time at each step
    """

    def __init__(self, ends: dict[Address, E], *, delays: Delays = at_once) -> None:
        self.now = 1000.0
        self.ends = ends
        self.delays = delays
        self.unreachable: set[Address] = set()
        self.forwards: dict[Address, Address] = {}
        self.events: dict[int, list[Event]] = {}
        self.sent: list[tuple[float, Address, Address, bytes]] = []
        self.tick: Callable[[float], None] = lambda now: None
        self._network = Network()

    def events_of(self, end: E) -> list[Event]:
        """Return the events of an end but the received bodies."""
        return [event for event in self.events.get(id(end), []) if not isinstance(event, BodyReceived)]

    def bodies_of(self, end: E) -> list[bytes]:
        """Return the bodies that an end has received."""
        return [event.body for event in self.events.get(id(end), []) if isinstance(event, BodyReceived)]

    def put(self, data: bytes, source: Address, target: Address) -> None:
        """Give the network a datagram."""
        self.sent.append((self.now, source, target, data))
        for delay in self.delays(data) if not {source, target} & self.unreachable else []:
            self._network.put(self.now + delay, source, target, data)

    def move(self, old: Address, new: Address, *, is_forwarded: bool = False) -> None:
        """Change an end's address. is_forwarded : whether what is sent to the old one still arrives"""
        self.ends[new] = self.ends.pop(old)
        if is_forwarded:
            self.forwards = {at: new if to == old else to for at, to in self.forwards.items()} | {old: new}

    def run(self, seconds: float) -> None:
        """Let time pass."""
        end = self.now + seconds
        while self.now < end - STEP_S / 2:
            self.tick(self.now)
            self.settle()
            self.now += STEP_S

    def settle(self) -> None:
        """Exchange datagrams until none is due, without letting time pass."""
        while self._send_all() or self._deliver():
            pass

    def _send_all(self) -> bool:
        before = len(self.sent)
        for address, end in list(self.ends.items()):
            for data, target in end.datagrams_to_send(self.now):
                self.put(data, address, target)
            self._collect(end)
        return len(self.sent) > before

    def _deliver(self) -> bool:
        for _, source, target, data in self._network.arrivals(self.now):
            end = self.ends.get(self.forwards.get(target, target))
            if end is not None:
                end.receive_datagram(data, source, self.now)
                self._collect(end)
            return True
        return False

    def _collect(self, end: E) -> None:
        self.events.setdefault(id(end), []).extend(iter(end.next_event, None))
