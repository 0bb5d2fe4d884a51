"""A relay in this process, on loopback."""

import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import zenoh

from conf.errors import NetworkError
from conf.relay.stun_responder import StunResponder
from conf.transport.interface import ReceivedDatagram
from conf.transport.relay_settings import make_config
from conf.transport.zenoh_transport import MAX_QUEUED, RelayTransport

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
        "transport/unicast/qos/enabled": True,
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


def wait_for(transport: RelayTransport, count: int = 1, *, seconds: float = LIMIT_S) -> list[ReceivedDatagram]:
    """Return what arrives, at least `count` datagrams."""
    arrived: list[ReceivedDatagram] = []
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        arrived += transport.receive(MAX_QUEUED)
        if len(arrived) >= count:
            return arrived
        transport.wait(0.05)
    raise TimeoutError(f"{len(arrived)} of {count} datagrams")


def exchange(waiter: RelayTransport, caller: RelayTransport) -> None:
    """Carry datagrams both ways until they arrive: what is declared takes a while to reach the other end."""
    arrived: list[ReceivedDatagram] = []
    for _ in range(200):
        caller.send([(b"hello", waiter.address)])
        waiter.wait(0.05)
        if arrived := waiter.receive(MAX_QUEUED):
            break
    assert arrived[0][:2] == (b"hello", caller.address)
    pass_once(waiter, caller, b"answer")


def pass_once(sender: RelayTransport, receiver: RelayTransport, data: bytes) -> None:
    """Send a datagram until it arrives, which it does once: on a busy machine zenoh may drop one, as networks do."""
    for _ in range(5):
        sender.send([(data, receiver.address)])
        with suppress(TimeoutError):
            assert [found[:2] for found in wait_for(receiver, seconds=2.0)] == [(data, sender.address)]
            return
    raise TimeoutError(f"{data!r} was sent five times")


@contextmanager
def running_responder() -> Iterator[tuple[str, int]]:
    """Run a STUN responder in a thread. Yields host and port of the relay beside which it would stand."""
    stopped = threading.Event()

    def run(responder: StunResponder) -> None:
        while not stopped.is_set():
            responder.step(time.monotonic())
            responder.wait(0.02)

    with bound_responder() as responder:
        thread = threading.Thread(target=run, args=(responder,))
        thread.start()
        try:
            yield LOOPBACK, responder.ports[0] - 1
        finally:
            stopped.set()
            thread.join()


def bound_responder() -> StunResponder:
    """Return a responder on free ports."""
    for _ in range(20):  # the two ports after a free one may be in use
        try:
            return StunResponder.bind(LOOPBACK, free_port() - 1)
        except NetworkError:
            continue
    raise AssertionError("no ports")
