"""A bad network to order: a UDP relay that loses, delays, reorders, doubles, damages and throttles.

    python tools/network/impair.py 127.0.0.1:6000 127.0.0.1:5005 --loss 0.05 --delay-ms 80 --jitter-ms 20

Datagrams to the first address go to the second, answers go back, and both ways are impaired alike. The same seed and
the same datagrams give the same faults. Each sender's address gets a socket of its own towards the receiver, so that
several senders can share the relay.
"""

import argparse
import heapq
import random
import select
import socket
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, fields
from itertools import count

Address = tuple[str, int]
MAX_QUEUE_S = 1.0  # a throttled link drops what would wait longer


@dataclass(frozen=True)
class Faults:
    """What goes wrong. Shares are 0 to 1.

    loss : of single datagrams; burst : of datagrams that begin a burst, burst_length datagrams long on average
    delay_ms : for all; jitter_ms : up to so much more for each, evenly spread
    reorder : share held back by reorder_ms; duplicate : share sent twice; corrupt : share with one bit turned
    kbps : of the link, headers counted, 0 for no limit
    outage : seconds without anything, from outage_at on, counted from the first datagram
    """

    loss: float = 0.0
    burst: float = 0.0
    burst_length: float = 4.0
    delay_ms: float = 0.0
    jitter_ms: float = 0.0
    reorder: float = 0.0
    reorder_ms: float = 50.0
    duplicate: float = 0.0
    corrupt: float = 0.0
    kbps: float = 0.0
    outage_at: float = 0.0
    outage: float = 0.0


class Impairment:
    """One direction of a bad link: a datagram in, its copies and their times of arrival out. Pure and seeded."""

    HEADER_BYTES = 28

    def __init__(self, faults: Faults, seed: int) -> None:
        self._faults = faults
        self._random = random.Random(seed)
        self._in_burst = False
        self._free_at = 0.0  # when the throttled link has sent what it was given
        self._began: float | None = None

    def pass_on(self, data: bytes, now: float) -> list[tuple[float, bytes]]:
        """Return what arrives of a datagram sent at `now`: (time, bytes), none if it is lost."""
        self._began = now if self._began is None else self._began
        if self._lost(now):
            return []
        through = self._throttle(len(data), now)
        if through is None:
            return []
        copies = 2 if self._happens(self._faults.duplicate) else 1
        return [(through + self._delay(), self._damage(data)) for _ in range(copies)]

    def _lost(self, now: float) -> bool:
        assert self._began is not None
        since = now - self._began - self._faults.outage_at
        chance = 1 / self._faults.burst_length if self._in_burst else self._faults.burst
        if self._happens(chance):
            self._in_burst = not self._in_burst
        return self._happens(self._faults.loss) or self._in_burst or 0 <= since < self._faults.outage

    def _throttle(self, size: int, now: float) -> float | None:
        if not self._faults.kbps:
            return now
        begin = max(now, self._free_at)
        if begin - now > MAX_QUEUE_S:
            return None
        self._free_at = begin + (size + self.HEADER_BYTES) * 8 / (self._faults.kbps * 1000)
        return self._free_at

    def _delay(self) -> float:
        held = self._faults.reorder_ms if self._happens(self._faults.reorder) else 0.0
        return (self._faults.delay_ms + self._random.random() * self._faults.jitter_ms + held) / 1000

    def _damage(self, data: bytes) -> bytes:
        if not data or not self._happens(self._faults.corrupt):
            return data
        damaged = bytearray(data)
        damaged[self._random.randrange(len(data))] ^= 1 << self._random.randrange(8)
        return bytes(damaged)

    def _happens(self, share: float) -> bool:
        return share > 0 and self._random.random() < share


class Relay:
    """The sockets, and the datagrams that are on their way."""

    def __init__(self, listen: Address, target: Address, faults: Faults, *, seed: int = 1) -> None:
        self._near = _udp_socket(listen)
        self._target = target
        self._there = Impairment(faults, seed)
        self._back = Impairment(faults, seed + 1)
        self._far: dict[Address, socket.socket] = {}  # sender's address -> socket towards the receiver
        self._flying: list[tuple[float, int, bytes, socket.socket, Address]] = []
        self._order = count()
        self.passed = 0

    @property
    def address(self) -> Address:
        """Where the relay listens."""
        host, port = self._near.getsockname()[:2]
        return host, port

    def run(self, seconds: float | None = None) -> None:
        """Relay for so long, or for ever."""
        end = float("inf") if seconds is None else time.monotonic() + seconds
        while (now := time.monotonic()) < end:
            due = self._flying[0][0] - now if self._flying else 0.5
            ready, _, _ = select.select([self._near, *self._far.values()], [], [], min(max(due, 0.0), 0.5))
            for link in ready:
                for data, address in _drain(link):
                    self._take(link, data, address)
            self._deliver(time.monotonic())

    def close(self) -> None:
        """Close every socket."""
        for link in (self._near, *self._far.values()):
            link.close()

    def _take(self, link: socket.socket, data: bytes, address: Address) -> None:
        now = time.monotonic()
        if link is self._near:
            if address not in self._far:
                self._far[address] = _udp_socket(("0.0.0.0", 0))
            arrivals, out, to = self._there.pass_on(data, now), self._far[address], self._target
        else:
            sender = next(near for near, far in self._far.items() if far is link)
            arrivals, out, to = self._back.pass_on(data, now), self._near, sender
        for arrival, copy in arrivals:
            heapq.heappush(self._flying, (arrival, next(self._order), copy, out, to))

    def _deliver(self, now: float) -> None:
        while self._flying and self._flying[0][0] <= now:
            _, _, data, link, to = heapq.heappop(self._flying)
            link.sendto(data, to)
            self.passed += 1


def _udp_socket(address: Address) -> socket.socket:
    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    link.bind(address)
    link.setblocking(False)
    return link


def _drain(link: socket.socket) -> Iterator[tuple[bytes, Address]]:
    try:
        for _ in range(1000):
            yield link.recvfrom(65535)
    except OSError:
        return


def _address(text: str) -> Address:
    host, _, port = text.rpartition(":")
    return host or "127.0.0.1", int(port)


def main() -> None:
    """Relay until interrupted."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("listen", type=_address, metavar="HOST:PORT")
    parser.add_argument("target", type=_address, metavar="HOST:PORT")
    for field in fields(Faults):
        parser.add_argument("--" + field.name.replace("_", "-"), type=float, default=field.default)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float)
    options = parser.parse_args()
    faults = Faults(**{field.name: getattr(options, field.name) for field in fields(Faults)})
    relay = Relay(options.listen, options.target, faults, seed=options.seed)
    print("relaying {}:{} -> {}:{}".format(*relay.address, *options.target), flush=True)
    try:
        relay.run(options.seconds)
    except KeyboardInterrupt:
        sys.exit(130)
    finally:
        relay.close()


if __name__ == "__main__":
    main()
