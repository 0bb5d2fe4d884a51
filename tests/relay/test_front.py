import os
import re
import socket
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
import zenoh

from conf.errors import NetworkError
from conf.relay.front import (
    FILES_PER_MEMBER,
    OTHER_FILES,
    Front,
    FrontCounts,
    FrontOptions,
    allow_files,
    find_router_ports,
)
from conf.relay.router import MAX_MEMBERS, Router, RouterOptions, RouterState
from conf.transport.relay_settings import client_settings, make_config
from conf.transport.stun import encode_request
from conf.transport.zenoh_transport import RelayTransport
from tests.support.relay import LOOPBACK, bound_responder, exchange, wait_until
from tests.support.simulated_sessions import seeded

DEPLOY = Path(__file__).parents[2] / "docs/deploy"

pytestmark = pytest.mark.slow


@contextmanager
def running_relay() -> Iterator[tuple[Front, Router, int]]:
    """Run a relay in this process. Yields its port too."""
    stopped = threading.Event()
    with bound_responder() as free:
        port = free.ports[0] - 1
    with ExitStack() as stack:
        front = stack.enter_context(Front.bind(FrontOptions((LOOPBACK, port), 100)))
        router = stack.enter_context(Router(RouterOptions((LOOPBACK, port), ports=front.router_ports)))

        def run() -> None:
            while not stopped.is_set():
                front.step(0.05)

        thread = threading.Thread(target=run)
        thread.start()
        try:
            yield front, router, port
        finally:
            stopped.set()
            thread.join()


def test_a_call_passes_over_udp_and_strangers_do_not_disturb_it() -> None:
    with (
        running_relay() as (front, router, port),
        RelayTransport.wait_at((LOOPBACK, port), "4711") as waiter,
        RelayTransport.call((LOOPBACK, port), "4711", seeded(1)) as caller,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger,
    ):
        exchange(waiter, caller)
        wait_until(lambda: waiter.carrier == caller.carrier == "udp")
        expected = RouterState(members=2, udp=2, tcp=2)
        wait_until(lambda: router.state() == expected, 20)
        for number in range(300):
            stranger.sendto(os.urandom(1) * (number + 1), (LOOPBACK, port))
        stranger.sendto(encode_request(bytes(12)), (LOOPBACK, port + 1))
        stranger.sendto(b"junk", (LOOPBACK, port + 2))
        wait_until(lambda: (front.counts().stun_answered, front.counts().stun_ignored) == (1, 1))
        exchange(waiter, caller)
        assert front.counts().strangers >= 250  # a few look as if they opened a session
    assert FrontCounts(strangers=1, excess=2, overflows=3, stun_ignored=4, forwarded=100).dropped == 10


def test_what_a_member_sends_is_limited() -> None:
    with (
        running_relay() as (front, _, port),
        RelayTransport.wait_at((LOOPBACK, port), "4711") as waiter,
        RelayTransport.call((LOOPBACK, port), "4711", seeded(2)) as caller,
        zenoh.open(make_config(client_settings((LOOPBACK, port)))) as stranger,
    ):
        exchange(waiter, caller)
        publisher = stranger.declare_publisher(
            "conf/call/4711/to/junk", reliability=zenoh.Reliability.BEST_EFFORT, express=True
        )

        def is_cut() -> bool:
            for _ in range(5):
                publisher.put(bytes(1400))
            return front.counts().excess > 10

        wait_until(is_cut)
        caller.send([(b"call", waiter.address)])
        wait_until(lambda: b"call" in [item.data for item in waiter.receive(1000)])


def test_ports_in_use_are_said_and_given_back() -> None:
    with running_relay() as (_, _, port), pytest.raises(NetworkError, match="cannot listen"):
        Front.bind(FrontOptions((LOOPBACK, port), 10))
    with Front.bind(FrontOptions((LOOPBACK, port), 10)) as front:
        assert front.stun_ports == [port + 1, port + 2]
    with bound_responder() as free:
        port = free.ports[0] - 1
    with socket.create_server((LOOPBACK, port)), pytest.raises(NetworkError, match=r"over TCP .*choose another"):
        Front.bind(FrontOptions((LOOPBACK, port), 10))


def test_two_ports_and_as_many_files_as_the_system_allows() -> None:
    first, second = find_router_ports()
    assert first != second
    resource = pytest.importorskip("resource", reason="Windows has no such limit")
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    allow_files(0)
    assert resource.getrlimit(resource.RLIMIT_NOFILE) == before
    allow_files(before[0] + 1)
    assert before[0] <= resource.getrlimit(resource.RLIMIT_NOFILE)[0] <= before[1]


def test_the_systemd_unit_allows_the_files_of_all_members() -> None:
    unit = (DEPLOY / "conf-relay.service").read_text()
    (limit,) = re.findall(r"^LimitNOFILE=(\d+)$", unit, re.MULTILINE)
    assert int(limit) == FILES_PER_MEMBER * MAX_MEMBERS + OTHER_FILES
