"""Simulate a bad network: a UDP relay that drops, delays, reorders, duplicates, corrupts and limits the rate.

    python tools/network/impair.py 127.0.0.1:6000 127.0.0.1:5005 --loss 0.05 --delay-ms 80 --jitter-ms 20

Datagrams to the first address are relayed to the second, answers are relayed back, and both directions are impaired
alike. The same seed and the same datagrams give the same faults. Each sender's address gets its own socket towards the
receiver, so that several senders can use one relay.
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
MAX_QUEUE_S = 1.0  # a link with a rate limit drops datagrams that would wait longer


@dataclass(frozen=True)
class Faults:
    """Faults of the link. All probabilities are per datagram, 0 to 1.

    loss : probability of a single loss; burst : of the start of a burst of losses, burst_length datagrams on average
    delay_ms : of all datagrams; jitter_ms : maximum additional delay, uniformly distributed
    reorder : probability of an additional delay of reorder_ms; duplicate, corrupt (one bit flipped) : probabilities
    kbps : rate limit including headers, 0 for none
    outage : seconds from outage_at on, after the first datagram, in which every datagram is lost
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
    """One direction of the link: returns the copies of each datagram and their times of arrival. Pure and seeded."""

    HEADER_BYTES = 28

    def __init__(self, faults: Faults, seed: int) -> None:
        self._faults = faults
        self._random = random.Random(seed)
        self._in_burst = False
        self._free_at = 0.0  # time at which the link with a rate limit has sent its queue
        self._started_at: float | None = None

    def transmit(self, data: bytes, now: float) -> list[tuple[float, bytes]]:
        """Return (time of arrival, bytes) of each copy of a datagram sent at `now`; none if it is lost."""
        self._started_at = now if self._started_at is None else self._started_at
        if self._lost(now):
            return []
        sent_at = self._limit_rate(len(data), now)
        if sent_at is None:
            return []
        copies = 2 if self._happens(self._faults.duplicate) else 1
        return [(sent_at + self._delay(), self._damage(data)) for _ in range(copies)]

    def _lost(self, now: float) -> bool:
        assert self._started_at is not None
        elapsed = now - self._started_at - self._faults.outage_at
        probability = 1 / self._faults.burst_length if self._in_burst else self._faults.burst
        if self._happens(probability):
            self._in_burst = not self._in_burst
        return self._happens(self._faults.loss) or self._in_burst or 0 <= elapsed < self._faults.outage

    def _limit_rate(self, size: int, now: float) -> float | None:
        if not self._faults.kbps:
            return now
        start = max(now, self._free_at)
        if start - now > MAX_QUEUE_S:
            return None
        self._free_at = start + (size + self.HEADER_BYTES) * 8 / (self._faults.kbps * 1000)
        return self._free_at

    def _delay(self) -> float:
        reordering = self._faults.reorder_ms if self._happens(self._faults.reorder) else 0.0
        return (self._faults.delay_ms + self._random.random() * self._faults.jitter_ms + reordering) / 1000

    def _damage(self, data: bytes) -> bytes:
        if not data or not self._happens(self._faults.corrupt):
            return data
        damaged = bytearray(data)
        damaged[self._random.randrange(len(data))] ^= 1 << self._random.randrange(8)
        return bytes(damaged)

    def _happens(self, probability: float) -> bool:
        return probability > 0 and self._random.random() < probability


class Relay:
    """The sockets of the relay and the datagrams in transit."""

    def __init__(self, listen: Address, target: Address, faults: Faults, *, seed: int = 1) -> None:
        self._near = _udp_socket(listen)
        self._target = target
        self._forward = Impairment(faults, seed)
        self._backward = Impairment(faults, seed + 1)
        self._far: dict[Address, socket.socket] = {}  # sender's address -> socket towards the receiver
        self._in_transit: list[tuple[float, int, bytes, socket.socket, Address]] = []
        self._order = count()
        self.passed = 0

    @property
    def address(self) -> Address:
        """Host and port on which the relay listens."""
        host, port = self._near.getsockname()[:2]
        return host, port

    def run(self, seconds: float | None = None) -> None:
        """Relay for so many seconds, or until interrupted."""
        end = float("inf") if seconds is None else time.monotonic() + seconds
        while (now := time.monotonic()) < end:
            due = self._in_transit[0][0] - now if self._in_transit else 0.5
            ready, _, _ = select.select([self._near, *self._far.values()], [], [], min(max(due, 0.0), 0.5))
            for udp in ready:
                for data, address in _drain(udp):
                    self._receive(udp, data, address)
            self._deliver(time.monotonic())

    def close(self) -> None:
        """Close every socket."""
        for udp in (self._near, *self._far.values()):
            udp.close()

    def _receive(self, udp: socket.socket, data: bytes, address: Address) -> None:
        now = time.monotonic()
        if udp is self._near:
            if address not in self._far:
                self._far[address] = _udp_socket(("0.0.0.0", 0))
            arrivals, out, to = self._forward.transmit(data, now), self._far[address], self._target
        else:
            sender = next(near for near, far in self._far.items() if far is udp)
            arrivals, out, to = self._backward.transmit(data, now), self._near, sender
        for arrival, copy in arrivals:
            heapq.heappush(self._in_transit, (arrival, next(self._order), copy, out, to))

    def _deliver(self, now: float) -> None:
        while self._in_transit and self._in_transit[0][0] <= now:
            _, _, data, udp, to = heapq.heappop(self._in_transit)
            udp.sendto(data, to)
            self.passed += 1


def _udp_socket(address: Address) -> socket.socket:
    udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    udp.bind(address)
    udp.setblocking(False)
    return udp


def _drain(udp: socket.socket) -> Iterator[tuple[bytes, Address]]:
    try:
        for _ in range(1000):
            yield udp.recvfrom(65535)
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
