"""Answer STUN Binding requests: tell a program from which address its datagrams come."""

import select
import socket
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from typing import Self

from conf.errors import NetworkError
from conf.protocol.rate_control.rate_limit import TokenBucket
from conf.transport.stun import STUN_PORT_STEPS, decode_request, encode_response
from conf.transport.udp import UdpSocket

ANSWERS_PER_S = 2000.0  # an answer is 12 B longer than its request, whose source may be forged
BATCH = 256


class StunResponder:
    """Sockets that answer; use `with`. answered, ignored : datagrams so far"""

    def __init__(self, sockets: Sequence[UdpSocket]) -> None:
        """Use `bind` instead."""
        self.answered = self.ignored = 0
        self._sockets = sockets
        self._bucket = TokenBucket(ANSWERS_PER_S, ANSWERS_PER_S)
        self._stack = ExitStack()
        for link in sockets:
            self._stack.enter_context(link)

    @classmethod
    def bind(cls, host: str, port: int) -> Self:
        """Return a responder for the relay at an address. Raises NetworkError if its ports are in use."""
        with ExitStack() as stack:
            sockets = [stack.enter_context(UdpSocket.bind(host, port + step)) for step in STUN_PORT_STEPS]
            stack.pop_all()
        return cls(sockets)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close its sockets."""
        self._stack.close()

    @property
    def handles(self) -> list[socket.socket]:
        """What becomes readable when a request has arrived."""
        return [handle for link in self._sockets for handle in link.handles]

    @property
    def ports(self) -> list[int]:
        """The ports of its sockets."""
        return [link.address[1] for link in self._sockets]

    def step(self, now: float) -> None:
        """Answer what has arrived."""
        for link in self._sockets:
            with suppress(NetworkError):  # passes, and nobody waits for an answer for long
                for data, address, _ in link.receive(BATCH):
                    transaction = decode_request(data)
                    if transaction is None or not self._bucket.consume(1, now):
                        self.ignored += 1
                        continue
                    link.send([(encode_response(transaction, address), address)])
                    self.answered += 1

    def wait(self, seconds: float) -> None:
        """Sleep until a datagram arrives, at most `seconds`."""
        select.select(self.handles, [], [], max(seconds, 0.0))
