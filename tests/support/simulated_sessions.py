"""A receiver, its senders and the network between them, in memory: seeded randomness, a clock that is a number."""

import copy
import heapq
import random
from collections.abc import Callable, Iterable
from itertools import count
from typing import Any

from conf.protocol.address import Address
from conf.protocol.session.client import SenderSession
from conf.protocol.session.events import BodyReceived, Event
from conf.protocol.session.server import SessionServer

CODE = "acorn-tulip-river-42"
WRONG = "acorn-tulip-river-43"
RECEIVER = ("192.0.2.1", 5005)
SENDER = ("198.51.100.7", 40000)
STEP_S = 0.1

# What happens to a datagram: the delay of each copy that arrives. None arrives from an empty list.
Fate = Callable[[bytes], Iterable[float]]


def seeded(seed: object) -> Callable[[int], bytes]:
    """Return a source of random bytes for tests."""
    return random.Random(f"{seed}").randbytes


def at_once(_data: bytes) -> list[float]:
    return [0.0]


class World:
    """Run everybody's timers and carry everybody's datagrams."""

    def __init__(self, fate: Fate = at_once, *, code: str = CODE, **options: Any) -> None:
        self.now = 1000.0
        self.fate = fate
        self.deaf: set[Address] = set()
        self.receiver = SessionServer(code, seeded("receiver"), **options)
        self.senders: dict[Address, SenderSession] = {}
        self.heard: dict[Address, list[Event]] = {RECEIVER: []}
        self.traffic: list[tuple[Address, Address, bytes]] = []
        self._flying: list[tuple[float, int, Address, Address, bytes]] = []
        self._order = count()

    def add_sender(self, address: Address = SENDER, code: str = CODE, **options: Any) -> SenderSession:
        sender = SenderSession(code, RECEIVER, seeded(address), self.now, **options)
        self.senders[address] = sender
        self.heard[address] = []
        return sender

    def restart_receiver(self, seed: str = "again", code: str = CODE, **options: Any) -> None:
        self.receiver = SessionServer(code, seeded(seed), **options)

    def send(self, data: bytes, source: Address, target: Address) -> None:
        self.traffic.append((source, target, data))
        for delay in self.fate(data) if target not in self.deaf else []:
            heapq.heappush(self._flying, (self.now + delay, next(self._order), source, target, data))

    def send_body(self, body: bytes, address: Address = SENDER) -> None:
        sealed = self.senders[address].seal_body(body)
        assert sealed is not None
        self.send(sealed.datagram, address, RECEIVER)

    def run(self, seconds: float) -> None:
        """Let time pass in steps, everything that is due happening on the way."""
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
        """Carry whatever can be carried without time passing."""
        while self._send_all() or self._deliver():
            pass

    def bodies(self, address: Address = RECEIVER) -> list[bytes]:
        return [event.body for event in self.heard[address] if isinstance(event, BodyReceived)]

    def events(self, address: Address = RECEIVER) -> list[Event]:
        return [event for event in self.heard[address] if not isinstance(event, BodyReceived)]

    def _send_all(self) -> bool:
        before = len(self.traffic)
        for address, sender in self.senders.items():
            for data, target in sender.datagrams_to_send(self.now):
                self.send(data, address, target)
        for data, target in self.receiver.datagrams_to_send(self.now):
            self.send(data, RECEIVER, target)
        self._collect()
        return len(self.traffic) > before

    def _deliver(self) -> bool:
        if not self._flying or self._flying[0][0] > self.now:
            return False
        _, _, source, target, data = heapq.heappop(self._flying)
        if target == RECEIVER:
            self.receiver.receive_datagram(data, source, self.now)
        elif target in self.senders:
            self.senders[target].receive_datagram(data, source, self.now)
        self._collect()
        return True

    def _collect(self) -> None:
        sides: list[tuple[Address, SessionServer | SenderSession]] = [
            (RECEIVER, self.receiver),
            *self.senders.items(),
        ]
        for address, side in sides:
            while (event := side.next_event()) is not None:
                self.heard[address].append(event)


def state(side: object) -> object:
    """Return all that a side knows, but for its counts of dropped datagrams and the tokens of its limits."""
    return _flatten(vars(side))


def _flatten(value: object) -> object:
    if isinstance(value, dict):
        return {
            key: _flatten(item) for key, item in value.items() if key not in {"dropped", "_unknown_replies", "_retries"}
        }
    if isinstance(value, list | tuple | set) or type(value).__name__ == "deque":
        return [_flatten(item) for item in value]  # type: ignore[attr-defined]
    if type(value).__module__.startswith("conf.protocol.") and hasattr(value, "__dict__"):
        return _flatten(vars(value))
    return copy.copy(value) if isinstance(value, int | float | str | bytes | None) else id(value)
