"""Two ends of a session, a relay between them and the networks on the direct path, in memory and in simulated time."""

import heapq
from collections.abc import Callable
from itertools import count

from conf.protocol.address import Address, RelayAddress
from conf.protocol.session.call_session import CallSession
from conf.protocol.session.events import BodyReceived, Event
from tests.support.simulated_sessions import seeded

CODE = "4711-acorn-tulip-river"
WAITING, CALLER = RelayAddress("4711", ""), RelayAddress("4711", "member")
LOCAL: tuple[Address, Address] = ("10.1.0.2", 40000), ("10.2.0.2", 40000)
PUBLIC: tuple[Address, Address] = ("192.0.2.11", 50001), ("192.0.2.12", 50002)
STEP_S = 0.02


class Nat:
    """A NAT without hairpinning, whose filter depends on address and port (RFC 4787).

    is_symmetric : each destination sees another port
    """

    def __init__(self, public: Address, *, is_symmetric: bool = False) -> None:
        self.public = public
        self.is_symmetric = is_symmetric
        self._mappings: dict[Address, Address] = {}

    def outbound(self, target: Address) -> Address:
        """Return the source that a destination sees."""
        host, port = self.public[0], self.public[1]
        assert isinstance(host, str) and isinstance(port, int)
        shift = len(self._mappings) + 1 if self.is_symmetric else 0
        return self._mappings.setdefault(target, (host, port + shift))

    def admits(self, source: Address, target: Address) -> bool:
        """Return whether a datagram from outside passes."""
        return self._mappings.get(source) == target


class PathWorld:
    """A waiting end (0) and a caller (1).

    delays_s : of the relay and of the direct path; is_relay_cut : whether the relay carries nothing
    cut : directions of the direct path that are broken: 0 from the waiting end, 1 from the caller
    sent : (time, source end, target, data); events : of both ends
    on_relay : what the relay does to a datagram: returns (delay, source address, target end, data) for each it sends
    """

    def __init__(self, *, symmetric: bool = False, relay_s: float = 0.02, announce: bool = True) -> None:
        self.now = 100.0
        self.ends = (
            CallSession(CODE, seeded("waiting"), self.now),
            CallSession(CODE, seeded("caller"), self.now, remote=WAITING),
        )
        self.nats = [Nat(public, is_symmetric=symmetric) for public in PUBLIC]
        self.relay_s, self.direct_s = relay_s, 0.01
        self.is_relay_cut = False
        self.cut: set[int] = set()
        self.is_lost: Callable[[], bool] = lambda: False
        self.sent: list[tuple[float, int, Address, bytes]] = []
        self.received: list[tuple[float, int, Address]] = []
        self.events: tuple[list[Event], list[Event]] = [], []
        self.bodies: tuple[list[tuple[float, bytes, Address]], list[tuple[float, bytes, Address]]] = [], []
        self.on_relay: Callable[[int, bytes], list[tuple[float, Address, int, bytes]]] = self.forward
        self.content_s = 0.5
        self._content_at = 0.0
        self._in_flight: list[tuple[float, int, int, Address, bytes]] = []
        self._order = count()
        if announce:
            for number, end in enumerate(self.ends):
                end.set_candidates([PUBLIC[number], LOCAL[number]])

    def forward(self, source: int, data: bytes) -> list[tuple[float, Address, int, bytes]]:
        """Carry a datagram over the relay, as an honest one does."""
        return [(self.relay_s, (WAITING, CALLER)[source], 1 - source, data)]

    @property
    def paths(self) -> tuple[str, str]:
        """The path in use of each end."""
        names = []
        for end in self.ends:
            kind = "relay" if isinstance(end.peer, RelayAddress) else "direct"
            names.append("none" if end.peer is None else kind)
        return names[0], names[1]

    def run(self, seconds: float, *, until: Callable[[], bool] = lambda: False) -> float:
        """Let time pass, at most until a condition holds. Returns how much has passed."""
        begin = self.now
        while self.now < begin + seconds and not until():
            if self.now >= self._content_at:
                self._content_at = self.now + self.content_s
                for number, end in enumerate(self.ends):
                    if sealed := end.seal_body(b"\x04content"):
                        self.put(number, sealed.datagram, sealed.address)
            for number, end in enumerate(self.ends):
                for data, target in end.datagrams_to_send(self.now):
                    self.put(number, data, target)
                self._collect(number)
            self.now += STEP_S
            self._deliver()
        return self.now - begin

    def put(self, source: int, data: bytes, target: Address) -> None:
        """Send a datagram."""
        self.sent.append((self.now, source, target, data))
        if self.is_lost():
            return
        if isinstance(target, RelayAddress):
            for delay, address, end, copy in [] if self.is_relay_cut else self.on_relay(source, data):
                self._fly(delay, end, address, copy)
            return
        seen = self.nats[source].outbound(target)
        if source not in self.cut and self.nats[1 - source].admits(seen, target):
            self._fly(self.direct_s, 1 - source, seen, data)

    def _fly(self, delay: float, end: int, source: Address, data: bytes) -> None:
        heapq.heappush(self._in_flight, (self.now + delay, next(self._order), end, source, data))

    def _deliver(self) -> None:
        while self._in_flight and self._in_flight[0][0] <= self.now:
            _, _, end, source, data = heapq.heappop(self._in_flight)
            self.received.append((self.now, end, source))
            self.ends[end].receive_datagram(data, source, self.now)
            self._collect(end)

    def _collect(self, number: int) -> None:
        while event := self.ends[number].next_event():
            if isinstance(event, BodyReceived):
                self.bodies[number].append((self.now, event.body, event.address))
            else:
                self.events[number].append(event)
