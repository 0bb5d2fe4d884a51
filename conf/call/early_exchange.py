"""Connect while the rest of the program is still loading."""

import time
from collections.abc import Callable
from types import TracebackType
from typing import Self

from conf.errors import NetworkError
from conf.stoppable_thread import StoppableThread
from conf.transport.exchange import DatagramExchange
from conf.transport.interface import Transport

POLL_S = 0.02


class EarlyExchange:
    """Exchanges datagrams in a thread while the `with` block lasts; the thread owns the endpoint until its end.

    connected_at : when there was a connection, on the clock, None before
    """

    def __init__(
        self,
        socket: Transport,
        exchange: DatagramExchange,
        is_connected: Callable[[float], bool],
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """is_connected : time -> whether the endpoint is in a call"""
        self.connected_at: float | None = None
        self._is_connected = is_connected
        self._socket = socket
        self._exchange = exchange
        self._clock = clock
        self._error: NetworkError | None = None
        self._thread = StoppableThread(self._run, name="connect")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop. Raises NetworkError if nothing could be sent or received."""
        self._thread.stop()
        if self._error is not None and error is None:
            raise self._error

    def _run(self) -> None:
        try:
            while not self._thread.is_stopped:
                now = self._clock()
                self._exchange.receive(now)
                self._exchange.send(now)
                if self.connected_at is None and self._is_connected(now):
                    self.connected_at = now
                self._socket.wait(POLL_S)
        except NetworkError as error:
            self._error = error
