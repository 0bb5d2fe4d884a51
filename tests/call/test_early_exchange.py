import threading
import time

import pytest

from conf.call.early_exchange import EarlyExchange
from conf.errors import NetworkError


class FakeExchange:
    """Counts its steps; the network may fail."""

    def __init__(self) -> None:
        self.log: list[str] = []
        self.fails = False

    def receive(self, now: float) -> bool:
        self.log.append("receive")
        if self.fails:
            raise NetworkError("nothing can be received")
        return False

    def send(self, now: float) -> None:
        self.log.append("send")


class FakeSocket:
    """Waits for a moment. waited : set by the third wait"""

    def __init__(self) -> None:
        self.waits = 0
        self.waited = threading.Event()

    def wait(self, seconds: float) -> None:
        self.waits += 1
        if self.waits == 3:
            self.waited.set()
        time.sleep(0.001)


def test_datagrams_are_exchanged_while_the_block_runs() -> None:
    exchange, socket, times = FakeExchange(), FakeSocket(), iter(range(10_000))
    early = EarlyExchange(
        socket,  # type: ignore[arg-type]
        exchange,  # type: ignore[arg-type]
        lambda now: now >= 1.0,
        clock=lambda: float(next(times)),
    )
    with early:
        assert socket.waited.wait(10.0)
    assert early.connected_at == 1.0
    count = len(exchange.log)
    assert exchange.log[:4] == ["receive", "send"] * 2
    time.sleep(0.01)
    assert len(exchange.log) == count


def test_a_failure_of_the_network_is_raised_at_the_end_of_the_block() -> None:
    exchange = FakeExchange()
    exchange.fails = True
    early = EarlyExchange(FakeSocket(), exchange, lambda now: False)  # type: ignore[arg-type]
    with pytest.raises(NetworkError, match="nothing can be received"), early:
        pass
    with pytest.raises(ValueError, match="first"), EarlyExchange(FakeSocket(), exchange, lambda now: False):  # type: ignore[arg-type]
        raise ValueError("first")
