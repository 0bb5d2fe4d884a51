"""Sessions in memory and in simulated time: a receiver, its senders and the network, with seeded randomness."""

import copy
import heapq
import random
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from itertools import count
from typing import Any

from conf.protocol.address import Address
from conf.protocol.session.client import SenderSession
from conf.protocol.session.events import BodyReceived, Event
from conf.protocol.session.server import SessionServer

CODE = "acorn-tulip-river-42"
WRONG = "acorn-tulip-river-43"
RECEIVER: Address = ("192.0.2.1", 5005)
SENDER: Address = ("198.51.100.7", 40000)
STEP_S = 0.1

# The delay of each copy of a datagram that arrives; an empty list loses it.
Delays = Callable[[bytes], Iterable[float]]


def seeded(seed: object) -> Callable[[int], bytes]:
    """Return a source of random bytes for tests."""
    return random.Random(f"{seed}").randbytes


def at_once(_data: bytes) -> list[float]:
    return [0.0]


def lose_all(_data: bytes) -> list[float]:
    return []


class Network:
    """Datagrams in flight: (arrival, source, target, data)."""

    def __init__(self) -> None:
        self._in_flight: list[tuple[float, int, Address, Address, bytes]] = []
        self._order = count()

    def put(self, arrival: float, source: Address, target: Address, data: bytes) -> None:
        heapq.heappush(self._in_flight, (arrival, next(self._order), source, target, data))

    def arrivals(self, now: float) -> Iterator[tuple[float, Address, Address, bytes]]:
        """Remove and yield what has arrived by `now`, in order of arrival."""
        while self._in_flight and self._in_flight[0][0] <= now:
            arrival, _, source, target, data = heapq.heappop(self._in_flight)
            yield arrival, source, target, data


class World:
    """Run all sessions and carry their datagrams.

    delays : what the network does to each datagram
    unreachable : addresses at which nothing arrives
    received : all events of each side, by address
    traffic : (source, target, data) of all datagrams
    """

    def __init__(self, delays: Delays = at_once, *, code: str = CODE, **options: Any) -> None:
        self.now = 1000.0
        self.delays = delays
        self.unreachable: set[Address] = set()
        self.receiver = SessionServer(code, seeded("receiver"), **options)
        self.senders: dict[Address, SenderSession] = {}
        self.received: dict[Address, list[Event]] = {RECEIVER: []}
        self.traffic: list[tuple[Address, Address, bytes]] = []
        self._network = Network()

    def add_sender(self, address: Address = SENDER, code: str = CODE, **options: Any) -> SenderSession:
        sender = SenderSession(code, RECEIVER, seeded(address), self.now, **options)
        self.senders[address] = sender
        self.received[address] = []
        return sender

    def move_sender(self, old: Address, new: Address) -> None:
        """Change the address of a sender."""
        self.senders[new], self.received[new] = self.senders.pop(old), self.received.pop(old)

    def restart_receiver(self, seed: str = "again", code: str = CODE, **options: Any) -> None:
        self.receiver = SessionServer(code, seeded(seed), **options)

    def send(self, data: bytes, source: Address, target: Address) -> None:
        self.traffic.append((source, target, data))
        for delay in self.delays(data) if target not in self.unreachable else []:
            self._network.put(self.now + delay, source, target, data)

    def send_body(self, body: bytes, address: Address = SENDER) -> None:
        sealed = self.senders[address].seal_body(body)
        assert sealed is not None
        self.send(sealed.datagram, address, RECEIVER)

    def run(self, seconds: float) -> None:
        """Let time pass in steps, with everything that is due meanwhile."""
        end = self.now + seconds
        while self.now < end:
            self.settle()
            self.now += STEP_S
        self.settle()

    def run_until(self, condition: Callable[[], bool], limit: float) -> None:
        """Let time pass until the condition holds. Fails if it does not hold within `limit` seconds."""
        end = self.now + limit
        while not condition():
            assert self.now < end
            self.run(STEP_S)

    def settle(self) -> None:
        """Exchange datagrams until none is due, without letting time pass."""
        while self._send_all() or self._deliver():
            pass

    def bodies(self, address: Address = RECEIVER) -> list[bytes]:
        return [event.body for event in self.received[address] if isinstance(event, BodyReceived)]

    def events(self, address: Address = RECEIVER) -> list[Event]:
        """Return the events of a side but the received bodies."""
        return [event for event in self.received[address] if not isinstance(event, BodyReceived)]

    def _send_all(self) -> bool:
        before = len(self.traffic)
        for address, sender in self.senders.items():
            for data, target in sender.datagrams_to_send(self.now):
                self.send(data, address, target)
        for data, target in self.receiver.datagrams_to_send(self.now):
            self.send(data, RECEIVER, target)
        self._collect_events()
        return len(self.traffic) > before

    def _deliver(self) -> bool:
        for _, source, target, data in self._network.arrivals(self.now):
            if target == RECEIVER:
                self.receiver.receive_datagram(data, source, self.now)
            elif target in self.senders:
                self.senders[target].receive_datagram(data, source, self.now)
            self._collect_events()
            return True
        return False

    def _collect_events(self) -> None:
        sides: list[tuple[Address, SessionServer | SenderSession]] = [(RECEIVER, self.receiver), *self.senders.items()]
        for address, side in sides:
            while (event := side.next_event()) is not None:
                self.received[address].append(event)


def state(side: object) -> object:
    """Return a copy of all that a side knows but its counts of dropped datagrams and the tokens of its rate limits."""
    return _flatten(vars(side))


def _flatten(value: object) -> object:
    if isinstance(value, dict):
        ignored = {"dropped", "_unknown_replies", "_retries"}
        return {key: _flatten(item) for key, item in value.items() if key not in ignored}
    if isinstance(value, list | tuple | set | deque):
        return [_flatten(item) for item in value]
    if type(value).__module__.startswith("conf.protocol.") and hasattr(value, "__dict__"):
        return _flatten(vars(value))
    return copy.copy(value) if isinstance(value, int | float | str | bytes | None) else id(value)
