"""Carry UDP datagrams between strangers and the router, and let through only what it should see.

Strategy. Each flow, what comes from one address and port, has a TCP connection of its own to the router. zenoh's
batches are the same on both, but for a length in front of each on TCP. The router's own UDP port would not do: one task
reads it and waits for each session to take its datagram, so that one slow session stops all (under a flood a call over
it lost 4 to 38 % of its datagrams, once 97 %).
A flow begins with what opens a session of zenoh (InitSyn), and is pending until the router says that it has accepted
the session (OpenAck), which nobody reaches who forges his address.
"""

import selectors
import socket
import struct
from collections.abc import Callable, Set
from contextlib import suppress
from typing import Any

from conf.relay.flow_limits import IDLE_S, PEER_FACTOR, Admission, receiving_limit, sending_limit
from conf.transport.udp import UdpSocket

BATCH = 256  # datagrams from strangers before others have their turn
MAX_BATCH_BYTES = 65_535  # zenoh joins messages into batches as large as a datagram may be
LENGTH = struct.Struct("<H")  # in front of a batch on TCP
# The first byte of a transport message of zenoh: kind, and whether it is an answer.
KIND, IS_ANSWER = 0x1F, 0x20
INIT, OPEN = 0x01, 0x02
MAX_TO_OPEN = 8  # batches of a pending flow: two, and what is repeated
CONNECT_S = 1.0
SO_MEMINFO, MEMINFO_DROPS = 55, 8  # linux/sock_diag.h: an option that Python has no name for
_MEMINFO = struct.Struct("@9I")


class Flow:
    """Datagrams between one address and the router."""

    __slots__ = ("address", "batches", "down", "heard_at", "host", "inner", "is_accepted", "opening", "outer", "up")

    def __init__(self, outer: socket.socket, inner: socket.socket, address: Any, factor: float, now: float) -> None:
        self.outer, self.inner, self.address = outer, inner, address
        self.host = str(address[0])
        self.up, self.down = sending_limit(factor), receiving_limit(factor)
        self.heard_at = now
        self.is_accepted = False
        self.opening = Opening()
        self.batches = Batches()

    def is_expected(self, data: bytes) -> bool:
        """Return whether a datagram may come now: while the flow is pending only what opens a session."""
        return self.is_accepted or self.opening.admits(data)


class Opening:
    """What a pending flow may send: batches that open a session, and few of them."""

    def __init__(self) -> None:
        self._left = MAX_TO_OPEN

    def admits(self, batch: bytes) -> bool:
        """Return whether a batch may pass, and count it."""
        self._left -= 1
        return self._left >= 0 and bool(batch) and batch[0] & (KIND | IS_ANSWER) in (INIT, OPEN)


class Batches:
    """Split a TCP stream into batches. rest : the bytes after the last complete one"""

    def __init__(self) -> None:
        self.rest = b""

    def split(self, data: bytes) -> list[bytes]:
        """Return the batches that are complete with these bytes."""
        data, found, start = self.rest + data, [], 0
        while len(data) - start >= LENGTH.size:
            first = start + LENGTH.size
            end = first + LENGTH.unpack_from(data, start)[0]
            if end > len(data):
                break
            found.append(data[first:end])
            start = end
        self.rest = data[start:]
        return found


class UdpFront:
    """The relay's UDP port.

    forwarded : datagrams to the router; strangers : dropped, of no flow; excess : dropped, above the limit of a flow
    """

    def __init__(
        self,
        outer: UdpSocket,
        router: tuple[str, int],
        selector: selectors.BaseSelector,
        *,
        max_flows: int,
        peers: Set[str] = frozenset(),
    ) -> None:
        """outer : is closed with it; router : where it listens for this over TCP; peers : relays that may carry more"""
        self.forwarded = self.strangers = self.excess = 0
        self._outer = outer
        self._router = router
        self._selector = selector
        self._peers = peers
        self._admission: Admission[Flow] = Admission(max_flows)
        self._flows: dict[Any, Flow] = {}
        for handle in outer.handles:
            selector.register(handle, selectors.EVENT_READ, self._reader_of(handle))

    @property
    def refused(self) -> int:
        """Return how many flows were not admitted."""
        return self._admission.refused

    @property
    def overflows(self) -> int:
        """Return how many datagrams the system has dropped as they came too fast; 0 where it does not tell."""
        count = 0
        for handle in self._outer.handles:
            with suppress(OSError, struct.error):  # another system, or an older kernel
                count += _MEMINFO.unpack(handle.getsockopt(socket.SOL_SOCKET, SO_MEMINFO, _MEMINFO.size))[MEMINFO_DROPS]
        return count

    def expire(self, now: float) -> None:
        """Close flows that have been pending or silent for too long."""
        for flow in self._admission.late(now):
            self._close(flow)
        for flow in [flow for flow in self._flows.values() if now - flow.heard_at > IDLE_S]:
            self._close(flow)

    def close(self) -> None:
        """Close all flows and the port."""
        for flow in list(self._flows.values()):
            self._close(flow)
        self._outer.close()

    def _reader_of(self, outer: socket.socket) -> Callable[[int, float], None]:
        return lambda _, now: self._receive(outer, now)

    def _receive(self, outer: socket.socket, now: float) -> None:
        """Carry what strangers have sent to the router."""
        flows = self._flows
        for _ in range(BATCH):
            try:
                data, address = outer.recvfrom(MAX_BATCH_BYTES)
            except ConnectionError:  # of a datagram sent earlier
                continue
            except OSError:  # nothing more
                return
            flow = flows.get(address)
            if flow is None:
                flow = self._open(outer, data, address, now)
            if flow is None or not flow.is_expected(data):
                self.strangers += 1
                continue
            flow.heard_at = now
            if flow.up.admits(len(data), now) and self._forward(flow, data):
                self.forwarded += 1
            else:
                self.excess += 1

    def _forward(self, flow: Flow, data: bytes) -> bool:
        """Send a batch to the router. Returns whether it has gone."""
        message = LENGTH.pack(len(data)) + data
        try:
            if flow.inner.send(message) == len(message):
                return True
        except BlockingIOError:  # the router is busy
            return False
        except OSError:
            pass
        self._close(flow)  # the router has closed it, or has got half a batch
        return False

    def _open(self, outer: socket.socket, data: bytes, address: Any, now: float) -> Flow | None:
        """Return a new flow; None if the datagram opens no session, or the flow is not admitted."""
        if not data or data[0] & (KIND | IS_ANSWER) != INIT or not self._admission.has_room(str(address[0])):
            return None
        inner = connect_to_router(self._router)
        if inner is None:
            return None
        flow = Flow(outer, inner, address, PEER_FACTOR if address[0] in self._peers else 1.0, now)
        self._flows[address] = flow
        self._selector.register(inner, selectors.EVENT_READ, lambda _, now: self._answer(flow, now))
        if evicted := self._admission.open(flow, flow.host, now):
            self._close(evicted)
        return flow

    def _answer(self, flow: Flow, now: float) -> None:
        """Carry what the router sends to its flow."""
        try:
            data = flow.inner.recv(MAX_BATCH_BYTES)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._close(flow)
            return
        for batch in flow.batches.split(data):
            if not flow.is_accepted and batch and batch[0] & (KIND | IS_ANSWER) == OPEN | IS_ANSWER:
                flow.is_accepted = True
                self._admission.accept(flow)
            if not flow.down.admits(len(batch), now):
                self.excess += 1
                continue
            with suppress(OSError):  # the network is busy, or cannot reach this address
                flow.outer.sendto(batch, flow.address)

    def _close(self, flow: Flow) -> None:
        if self._flows.get(flow.address) is not flow:
            return
        del self._flows[flow.address]
        self._admission.close(flow, flow.host)
        self._selector.unregister(flow.inner)
        flow.inner.close()


def connect_to_router(router: tuple[str, int], /) -> socket.socket | None:
    """Return a connection with the router, which is on this machine and so answers at once; None if it does not."""
    try:
        inner = socket.create_connection(router, timeout=CONNECT_S)
    except OSError:
        return None
    inner.setblocking(False)
    inner.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return inner
