import json
import threading
import time
from contextlib import ExitStack
from pathlib import Path

import pytest
import zenoh

from conf.errors import NetworkError
from conf.relay.router import Router, RouterOptions, RouterState, router_settings
from conf.transport.relay_settings import Credentials, client_settings, make_config
from conf.transport.udp import MAX_DATAGRAM
from conf.transport.zenoh_transport import RelayTransport
from tests.support.relay import LOOPBACK, exchange, free_port, wait_until
from tests.support.simulated_sessions import seeded

KEY = "conf/call/4711/to/aaaa"
pytestmark = pytest.mark.slow


def client(port: int, credentials: Credentials | None = None) -> zenoh.Session:
    return zenoh.open(make_config(client_settings((LOOPBACK, port), credentials)))


def test_a_call_passes_and_is_counted() -> None:
    port = free_port()
    with (
        Router(RouterOptions((LOOPBACK, port))) as router,
        RelayTransport.wait_at((LOOPBACK, port), "4711") as waiter,
        RelayTransport.call((LOOPBACK, port), "4711", seeded(1)) as caller,
    ):
        exchange(waiter, caller)
        expected = RouterState(members=2, udp=2, tcp=2)
        wait_until(lambda: router.state() == expected)


def test_two_relays_join_their_members(tmp_path: Path) -> None:
    first, second = free_port(), free_port()
    password = tmp_path / "password"
    password.write_text("alice:secret\n")
    options = RouterOptions((LOOPBACK, second), [(LOOPBACK, first)], password)
    alice = Credentials("alice", "secret")
    began = time.monotonic()
    with Router(options) as router:  # before the other is there
        assert time.monotonic() - began < 5
        with Router(RouterOptions((LOOPBACK, first), (), password)):
            wait_until(lambda: router.state().peers == 1)
            with (
                RelayTransport.wait_at((LOOPBACK, first), "4711", credentials=alice) as waiter,
                RelayTransport.call((LOOPBACK, second), "4711", seeded(2), credentials=alice) as caller,
            ):
                exchange(waiter, caller)
                wait_until(lambda: router.state().members == 1)


def test_only_who_has_the_password_is_admitted(tmp_path: Path) -> None:
    port, password = free_port(), tmp_path / "password"
    password.write_text("alice:secret\nbob:other\n")
    with Router(RouterOptions((LOOPBACK, port), (), password)):
        for user, word in (("alice", "secret"), ("bob", "other")):
            client(port, Credentials(user, word)).close()
        for wrong in (Credentials("alice", "other"), Credentials("carol", "secret"), None):
            with pytest.raises(zenoh.ZError):
                client(port, wrong)


def test_members_are_limited() -> None:
    port = free_port()
    with Router(RouterOptions((LOOPBACK, port), max_members=2)) as router, client(port), client(port):
        with pytest.raises(zenoh.ZError):
            client(port)
        assert router.state().members == 2


def test_members_publish_and_subscribe_below_one_key_only() -> None:
    port, keys = free_port(), set[str]()
    with Router(RouterOptions((LOOPBACK, port))), client(port) as sender, client(port) as receiver:
        for name in ("other/**", "conf/**", "@/**"):
            receiver.declare_subscriber(name, lambda sample: keys.add(str(sample.key_expr)))
        wait_until(lambda: [sender.put(KEY, b"a"), keys == {KEY}][1])
        for key in ("other/a", "conf/b"):
            sender.put(key, b"a")
        wait_until(lambda: "conf/b" in keys)
        assert keys == {KEY, "conf/b"}
        router_replies = [reply for reply in sender.get("@/*/router/**", timeout=0.3) if reply.ok]
        assert router_replies == []


def test_messages_longer_than_a_datagram_are_dropped() -> None:
    port, sizes = free_port(), list[int]()
    with Router(RouterOptions((LOOPBACK, port))), client(port) as sender, client(port) as receiver:
        receiver.declare_subscriber("conf/**", lambda sample: sizes.append(len(sample.payload)))
        wait_until(lambda: [sender.put(KEY, b""), sizes][1])
        for size in (100_000, MAX_DATAGRAM + 1, MAX_DATAGRAM, 1):
            sender.put(KEY, bytes(size))
        wait_until(lambda: 1 in sizes)
        assert set(sizes) == {0, MAX_DATAGRAM, 1}


def test_a_port_in_use_is_said() -> None:
    port = free_port()
    options = RouterOptions((LOOPBACK, port))
    with Router(options), pytest.raises(NetworkError, match=f"cannot listen on {LOOPBACK}:{port}: another program"):
        Router(options)


def test_all_addresses_are_listened_on() -> None:
    config = make_config(router_settings(RouterOptions(("", 7447)), None))
    assert set(json.loads(config.get_json("listen/endpoints"))) <= {
        *("tcp/[::]:7447", "udp/[::]:7447", "tcp/0.0.0.0:7447", "udp/0.0.0.0:7447")
    }


def test_members_arrive_while_they_are_counted() -> None:
    """An earlier count asked the admin space, which could stop the router for good."""
    port, states, stopped = free_port(), list[RouterState](), threading.Event()
    with Router(RouterOptions((LOOPBACK, port))) as router, ExitStack() as stack:

        def count() -> None:
            while not stopped.wait(0.01):
                states.append(router.state())

        counter = threading.Thread(target=count)
        counter.start()
        try:
            for number in range(30):
                session = stack.enter_context(client(port))
                session.declare_subscriber(f"conf/call/{number}/to/*", lambda sample: None)
            wait_until(lambda: states and states[-1].members == 30)
        finally:
            stopped.set()
            counter.join()
    assert "adminspace/enabled" not in router_settings(RouterOptions((LOOPBACK, port)), None)
