"""A relay in this process, on loopback."""

import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import zenoh

from conf.transport.relay_settings import make_config

LOOPBACK = "127.0.0.1"
LIMIT_S = 10.0


def free_port() -> int:
    """Return a port that nobody uses for TCP."""
    with socket.socket() as handle:
        handle.bind((LOOPBACK, 0))
        return int(handle.getsockname()[1])


@contextmanager
def router(port: int, kinds: str = "tcp udp") -> Iterator[zenoh.Session]:
    """Run a router. kinds : protocols that it listens on"""
    settings = {
        "mode": "router",
        "listen/endpoints": [f"{kind}/{LOOPBACK}:{port}" for kind in kinds.split()],
        "scouting/multicast/enabled": False,
        "timestamping/enabled": False,
        "transport/unicast/max_links": 2,
        "transport/unicast/qos/enabled": False,
        "transport/shared_memory/enabled": False,
    }
    session = zenoh.open(make_config(settings))
    try:
        yield session
    finally:
        session.close()


def wait_until(condition: Callable[[], object], seconds: float = LIMIT_S) -> None:
    """Wait for a condition that other threads bring about. Raises TimeoutError."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError(f"not within {seconds:.0f} s")
        time.sleep(0.01)
