"""What a relay lets in: how much a flow may carry, and how many flows there may be. Sans-IO.

A flow is what comes from one address and port over UDP, or one TCP connection. Whoever opens one is a stranger until
the router has accepted it; until then a flow is pending, and a new one displaces the oldest of too many.
"""

import ipaddress
from collections import Counter, OrderedDict
from typing import Generic, TypeVar

from conf.protocol.rate_control.rate_limit import TokenBucket

# Of what a member sends; a call with voice and portrait needs a tenth. What it receives may be of many.
SENT_PER_S, SENT_AT_ONCE = 100_000.0, 200_000.0
RECEIVED_PER_S, RECEIVED_AT_ONCE = 400_000.0, 800_000.0
DATAGRAM_COST = 100  # bytes that a datagram counts more than it has, as small ones cost as much work
PEER_FACTOR = 100.0  # what another relay may carry more than a member
MAX_PENDING = 64  # of one protocol
MAX_PENDING_PER_HOST = 16
PENDING_S = 5.0
IDLE_S = 60.0  # zenoh gives up a link after LEASE_MS = 40 s
HOST_PART = 4  # no address may have more than one flow in four
MIN_PER_HOST = 16
IPV6_HOST_BITS = 64  # a network of this size is one home

Flow = TypeVar("Flow")


class FlowLimit:
    """The bytes that one flow may carry in one direction."""

    def __init__(self, per_s: float, at_once: float) -> None:
        self._bucket = TokenBucket(per_s, at_once)

    def admits(self, size: int, now: float) -> bool:
        """Return whether a datagram may pass, and count it if so."""
        return self._bucket.consume(size + DATAGRAM_COST, now)

    def delay_after(self, size: int, now: float) -> float:
        """Count a part of a TCP stream. Returns the seconds until the next may be read."""
        self._bucket.force_take(size, now)
        return self._bucket.time_until(0, now)


def sending_limit(factor: float = 1.0) -> FlowLimit:
    """Return the limit of what a member sends."""
    return FlowLimit(SENT_PER_S * factor, SENT_AT_ONCE * factor)


def receiving_limit(factor: float = 1.0) -> FlowLimit:
    """Return the limit of what a member receives."""
    return FlowLimit(RECEIVED_PER_S * factor, RECEIVED_AT_ONCE * factor)


class Admission(Generic[Flow]):
    """Which flows of one protocol there are.

    refused : flows that were not admitted, or closed while they were pending
    """

    def __init__(self, max_flows: int) -> None:
        self.refused = self._count = 0
        self._max_flows = max_flows
        self._max_per_host = max(max_flows // HOST_PART, MIN_PER_HOST)
        self._flows: Counter[str] = Counter()
        self._pending_of: Counter[str] = Counter()
        self._pending: OrderedDict[Flow, tuple[str, float]] = OrderedDict()

    def has_room(self, host: str) -> bool:
        """Return whether a host may open a flow."""
        key = host_key(host)
        has_room = (
            self._count < self._max_flows
            and self._flows[key] < self._max_per_host
            and self._pending_of[key] < MAX_PENDING_PER_HOST
        )
        self.refused += not has_room
        return has_room

    def open(self, flow: Flow, host: str, now: float) -> Flow | None:
        """Note a new flow, which is pending. Returns one that must be closed for it."""
        key = host_key(host)
        self._count += 1
        self._flows[key] += 1
        self._pending_of[key] += 1
        self._pending[flow] = key, now
        if len(self._pending) <= MAX_PENDING:
            return None
        self.refused += 1
        return next(iter(self._pending))

    def accept(self, flow: Flow) -> None:
        """Note that the router has accepted a flow."""
        if entry := self._pending.pop(flow, None):
            _decrement(self._pending_of, entry[0])

    def close(self, flow: Flow, host: str) -> None:
        """Note that a flow is no more."""
        self.accept(flow)
        self._count -= 1
        _decrement(self._flows, host_key(host))

    def late(self, now: float) -> list[Flow]:
        """Return the flows that have been pending for too long, which must be closed, and count them."""
        late = [flow for flow, (_, since) in self._pending.items() if now - since > PENDING_S]
        self.refused += len(late)
        return late


def host_key(host: str) -> str:
    """Return what stands for one home: an IPv4 address, or the first half of an IPv6 address."""
    if ":" not in host:
        return host
    address = ipaddress.IPv6Address(host.partition("%")[0])
    return str(int(address) >> IPV6_HOST_BITS)


def _decrement(counter: Counter[str], key: str) -> None:
    counter[key] -= 1
    if counter[key] <= 0:
        del counter[key]
