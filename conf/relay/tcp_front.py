"""Carry TCP connections between members and the router, each with a limit and without storing more than it forwards.

Until the router has accepted its session, a connection may send what opens one and nothing else.
"""

import selectors
import socket
from collections.abc import Callable, Sequence, Set
from contextlib import suppress
from typing import Any

from conf.relay.flow_limits import PEER_FACTOR, Admission, FlowLimit, receiving_limit, sending_limit
from conf.relay.udp_front import IS_ANSWER, KIND, LENGTH, OPEN, Batches, Opening, connect_to_router

READ_BYTES = 16_384
MAX_OPENING_BYTES = 4096  # that a pending connection may send at once or without completing a batch; one has under 300
ACCEPT_BATCH = 32
BACKLOG = 256


class Stream:
    """One direction of a connection. rest : what was read and could not be written yet"""

    def __init__(self, source: socket.socket, sink: socket.socket, limit: FlowLimit) -> None:
        self.source, self.sink, self.limit = source, sink, limit
        self.rest = b""
        self.paused_until = 0.0


class Connection:
    """A connection of a member, and the one to the router that belongs to it."""

    def __init__(self, outer: socket.socket, inner: socket.socket, host: str, factor: float) -> None:
        self.host = host
        self.up = Stream(outer, inner, sending_limit(factor))
        self.down = Stream(inner, outer, receiving_limit(factor))
        self.is_accepted = False
        self.opening, self.batches = Opening(), Batches()

    def opened_with(self, data: bytes) -> bytes | None:
        """Return what may pass of the bytes that a pending connection has sent; None if they open no session."""
        if len(self.batches.rest) + len(data) > MAX_OPENING_BYTES:
            return None
        found = self.batches.split(data)
        is_opening = all([self.opening.admits(batch) for batch in found])
        return b"".join(LENGTH.pack(len(batch)) + batch for batch in found) if is_opening else None


class TcpFront:
    """The relay's TCP port.

    strangers : connections that were closed, as what they sent opens no session
    read_bytes : from members and the router; paused : how often a stream had to wait, as it was above its limit
    """

    def __init__(
        self,
        listeners: Sequence[socket.socket],
        router: tuple[str, int],
        selector: selectors.BaseSelector,
        *,
        max_flows: int,
        peers: Set[str] = frozenset(),
    ) -> None:
        """listeners : are closed with it; peers : addresses of other relays, which may carry more"""
        self.strangers = self.read_bytes = self.paused = 0
        self._listeners = listeners
        self._router = router
        self._selector = selector
        self._peers = peers
        self._admission: Admission[Connection] = Admission(max_flows)
        self._connections: set[Connection] = set()
        self._waiting: dict[Stream, Connection] = {}
        for listener in listeners:
            listener.setblocking(False)
            selector.register(listener, selectors.EVENT_READ, self._acceptor_of(listener))

    @property
    def refused(self) -> int:
        """Return how many connections were not admitted."""
        return self._admission.refused

    @property
    def is_waiting(self) -> bool:
        """Return whether `resume` must be called soon."""
        return bool(self._waiting)

    def expire(self, now: float) -> None:
        """Close connections that have been pending for too long."""
        for connection in self._admission.late(now):
            self._close(connection)

    def resume(self, now: float) -> None:
        """Go on with what had to wait."""
        for stream, connection in [item for item in self._waiting.items() if now >= item[0].paused_until]:
            del self._waiting[stream]
            self._watch(connection)

    def close(self) -> None:
        """Close all connections and the port."""
        for connection in list(self._connections):
            self._close(connection)
        for listener in self._listeners:
            listener.close()

    def _acceptor_of(self, listener: socket.socket) -> Callable[[int, float], None]:
        return lambda _, now: self._accept(listener, now)

    def _accept(self, listener: socket.socket, now: float) -> None:
        for _ in range(ACCEPT_BATCH):
            try:
                outer, address = listener.accept()
            except OSError:  # nothing more, or no descriptors left
                return
            if not self._admission.has_room(str(address[0])) or not (inner := connect_to_router(self._router)):
                outer.close()
                continue
            self._open(outer, inner, address, now)

    def _open(self, outer: socket.socket, inner: socket.socket, address: Any, now: float) -> None:
        host = str(address[0])
        connection = Connection(outer, inner, host, PEER_FACTOR if host in self._peers else 1.0)
        outer.setblocking(False)
        with suppress(OSError):
            outer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for stream in (connection.up, connection.down):
            self._selector.register(stream.source, selectors.EVENT_READ, self._handler_of(connection, stream))
        self._connections.add(connection)
        if evicted := self._admission.open(connection, host, now):
            self._close(evicted)

    def _handler_of(self, connection: Connection, stream: Stream) -> Callable[[int, float], None]:
        """Return what to do when the source of a stream is ready: write what waits to be sent there, or read."""
        other = connection.down if stream is connection.up else connection.up

        def on_ready(mask: int, now: float) -> None:
            try:
                if mask & selectors.EVENT_WRITE:
                    self._write(other)
                if mask & selectors.EVENT_READ and not stream.rest:
                    self._read(connection, stream, now)
            except BlockingIOError:
                return
            except OSError:  # closed by one side
                self._close(connection)
                return
            if connection in self._connections:
                self._watch(connection)

        return on_ready

    def _read(self, connection: Connection, stream: Stream, now: float) -> None:
        data = stream.source.recv(READ_BYTES)
        if not data:
            raise ConnectionResetError
        if not connection.is_accepted and stream is connection.down and len(data) > LENGTH.size:
            if data[LENGTH.size] & (KIND | IS_ANSWER) == OPEN | IS_ANSWER:
                connection.is_accepted = True
                self._admission.accept(connection)
        self.read_bytes += len(data)
        if stream is connection.up and not connection.is_accepted:
            opening = connection.opened_with(data)
            if opening is None:
                self.strangers += 1
                raise ConnectionResetError
            stream.rest = opening
        elif stream is connection.up and connection.batches.rest:
            stream.rest, connection.batches.rest = connection.batches.rest + data, b""
        else:
            stream.rest = data
        if delay := stream.limit.delay_after(len(data), now):
            self.paused += 1
            stream.paused_until = now + delay
            self._waiting[stream] = connection
        with suppress(BlockingIOError):
            self._write(stream)

    def _write(self, stream: Stream) -> None:
        if stream.rest:
            stream.rest = stream.rest[stream.sink.send(stream.rest) :]

    def _watch(self, connection: Connection) -> None:
        """Wait for what each side can do next: read if nothing waits, write if something does."""
        up, down = connection.up, connection.down
        for stream, other in ((up, down), (down, up)):
            events = 0 if stream.rest or stream in self._waiting else selectors.EVENT_READ
            events |= selectors.EVENT_WRITE if other.rest else 0
            key = self._selector.get_map().get(stream.source)
            handler = self._handler_of(connection, stream) if key is None else key.data
            if key is None and events:
                self._selector.register(stream.source, events, handler)
            elif key and not events:
                self._selector.unregister(stream.source)
            elif key and key.events != events:
                self._selector.modify(stream.source, events, handler)

    def _close(self, connection: Connection) -> None:
        if connection not in self._connections:
            return
        self._connections.discard(connection)
        self._admission.close(connection, connection.host)
        for stream in (connection.up, connection.down):
            self._waiting.pop(stream, None)
            with suppress(KeyError):
                self._selector.unregister(stream.source)
            stream.source.close()
