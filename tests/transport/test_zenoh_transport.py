import threading

import pytest

from conf.errors import NetworkError
from conf.protocol.address import RelayAddress
from conf.transport.relay_settings import KEY_PREFIX
from conf.transport.zenoh_transport import MAX_MEMBERS, MAX_QUEUED, RelayTransport
from tests.support.relay import LOOPBACK, exchange, free_port, pass_once, router, wait_until
from tests.support.simulated_sessions import seeded

PLATE = "4711"
WAITER = RelayAddress(PLATE, "")


@pytest.mark.slow
@pytest.mark.parametrize(("kinds", "carrier"), [("tcp udp", "udp"), ("tcp", "tcp")])
def test_datagrams_pass_both_ways(kinds: str, carrier: str) -> None:
    port = free_port()
    with (
        router(port, kinds),
        RelayTransport.wait_at((LOOPBACK, port), PLATE) as waiter,
        RelayTransport.call((LOOPBACK, port), PLATE, seeded(1)) as caller,
    ):
        assert (waiter.remote, caller.remote, waiter.address) == (None, WAITER, WAITER)
        assert caller.address.member and caller.note == ""
        wait_until(lambda: waiter.is_open and caller.is_open)
        assert waiter.carrier == caller.carrier == carrier
        exchange(waiter, caller)
        for number in range(10):  # with longer keys first, then with declared ones: each arrives once
            pass_once(waiter, caller, bytes([number]))
            pass_once(caller, waiter, bytes([number]))
        assert waiter.unsent == waiter.dropped == caller.dropped == 0


@pytest.mark.slow
def test_a_relay_that_restarts_is_used_again() -> None:
    port = free_port()
    with (
        RelayTransport.wait_at((LOOPBACK, port), PLATE) as waiter,
        RelayTransport.call((LOOPBACK, port), PLATE, seeded(2)) as caller,
    ):
        wait_until(lambda: caller.note and waiter.note)
        assert not caller.is_open and caller.carrier == ""
        with pytest.raises(NetworkError, match=f"the relay {LOOPBACK}:{port} does not answer"):
            caller.send([(b"a", WAITER)])
        for _ in range(2):
            with router(port):
                wait_until(lambda: caller.is_open and waiter.is_open)
                exchange(waiter, caller)
            wait_until(lambda: caller.note and waiter.note)


@pytest.mark.slow
def test_what_strangers_send_is_bounded() -> None:
    port = free_port()
    with router(port) as stranger, RelayTransport.wait_at((LOOPBACK, port), PLATE) as waiter:
        wait_until(lambda: waiter.is_open)
        key = f"{KEY_PREFIX}/{PLATE}/to"
        wait_until(lambda: [stranger.put(f"{key}/aaaa", b"a"), waiter.receive(1)][1])
        for name, size in (("aaaa", 5000), ("AAAA", 1), ("a" * 17, 1), ("0", 1)):
            stranger.put(f"{key}/{name}", bytes(size))
        wait_until(lambda: waiter.dropped == 4)
        for number in range(MAX_QUEUED + 100):
            stranger.put(f"{key}/b", number.to_bytes(2, "big"))
        wait_until(lambda: waiter.dropped >= 104)
        assert len(waiter.receive(10 * MAX_QUEUED)) <= MAX_QUEUED
        for number in range(10 * MAX_MEMBERS):
            name = "".join("abcdefghij"[int(digit)] for digit in f"{number:03}")
            waiter.send([(b"a", RelayAddress(PLATE, name))] * 4)
        assert waiter._route and len(waiter._route._counts) <= MAX_MEMBERS  # type: ignore[union-attr]


def test_a_nameplate_is_part_of_a_key() -> None:
    for plate in ("", "a/b", "**", "A", "x" * 33):
        with pytest.raises(ValueError, match="nameplate"):
            RelayTransport(plate, relay=(LOOPBACK, 1))


@pytest.mark.slow
def test_without_a_relay_the_path_is_the_local_network() -> None:
    with RelayTransport.wait_at(None, PLATE) as waiter:
        assert waiter.path_name(RelayAddress(PLATE, "aaaa")) == "local network"


@pytest.mark.slow
def test_addresses_of_other_calls_are_not_sent_to() -> None:
    port = free_port()
    with router(port), RelayTransport.wait_at((LOOPBACK, port), PLATE) as waiter:
        wait_until(lambda: waiter.is_open)
        waiter.send([(b"a", RelayAddress("4712", "aaaa")), (b"a", ("192.0.2.1", 1))])
        assert waiter.unsent == 2


@pytest.mark.slow
def test_both_ends_know_whether_somebody_waits_with_the_nameplate() -> None:
    port = free_port()
    relay = LOOPBACK, port
    with router(port), RelayTransport.call(relay, PLATE, seeded(3)) as caller:
        wait_until(lambda: caller.is_open)
        assert not caller.others_wait
        with RelayTransport.wait_at(relay, PLATE) as waiter, RelayTransport.wait_at(relay, "4712") as other:
            wait_until(lambda: caller.others_wait)
            assert not waiter.others_wait and not other.others_wait
            with RelayTransport.wait_at(relay, PLATE) as second:
                wait_until(lambda: waiter.others_wait and second.others_wait)
            wait_until(lambda: not waiter.others_wait)
        wait_until(lambda: not caller.others_wait)


@pytest.mark.slow
def test_no_thread_is_left_after_it_is_closed() -> None:
    """One inside zenoh would abort the process when the interpreter ends."""
    port, before = free_port(), set(threading.enumerate())
    with router(port), RelayTransport.wait_at((LOOPBACK, port), PLATE) as waiter:
        wait_until(lambda: waiter.is_open)
        assert {thread.name for thread in set(threading.enumerate()) - before} == {"relay", "relay-receive"}
        waiter.send([(b"a", RelayAddress(PLATE, "aaaa"))] * 4)  # declares its key
        wait_until(lambda: waiter._route and waiter._route._publishers)  # type: ignore[union-attr]
        waiter.close()
        assert set(threading.enumerate()) == before
