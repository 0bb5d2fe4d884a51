"""A network in memory: two sans-IO halves, a delay for each datagram and a list of losses. No sockets, no sleeping."""

import heapq
from collections.abc import Iterable, Iterator
from itertools import count


class FakeNet:
    """Carry datagrams one way. `lost` says for each datagram in turn whether it vanishes; `delays` when it arrives."""

    def __init__(self, lost: Iterable[bool] = (), delays: Iterable[float] = ()) -> None:
        self._lost: Iterator[bool] = iter(lost)
        self._delays: Iterator[float] = iter(delays)
        self._order = count()
        self._flying: list[tuple[float, int, bytes]] = []

    def send(self, datagrams: Iterable[bytes], now: float) -> None:
        """Put datagrams on the way."""
        for data in datagrams:
            if not next(self._lost, False):
                heapq.heappush(self._flying, (now + next(self._delays, 0.0), next(self._order), data))

    def arrivals(self, now: float) -> Iterator[tuple[float, bytes]]:
        """Take what has arrived by `now`, each with the time of its arrival."""
        while self._flying and self._flying[0][0] <= now:
            arrival, _, data = heapq.heappop(self._flying)
            yield arrival, data
