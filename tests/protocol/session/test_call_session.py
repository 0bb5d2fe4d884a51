"""One session of two ends: who calls whom, glare, a third caller, a peer that comes back."""

from collections.abc import Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conf.protocol.address import Address
from conf.protocol.session.call_session import OTHER_HOST_SILENCE_S, CallSession
from conf.protocol.session.client import SILENCE_S
from conf.protocol.session.drop_reasons import DropReason
from conf.protocol.session.events import Connected, LossReason, Refused, SessionEnded
from conf.protocol.session.handshake import Refusal
from tests.support.simulated_call import A, B, Link
from tests.support.simulated_sessions import CODE, seeded

C: Address = ("203.0.113.9", 9)
BEGIN = 1000.0


def called(seed: object = "called") -> CallSession:
    return CallSession(CODE, seeded(seed), BEGIN)


def calling(remote: Address, seed: object = "calling", now: float = BEGIN) -> CallSession:
    return CallSession(CODE, seeded(seed), now, remote=remote)


def exchange(link: Link[CallSession]) -> None:
    """Let each end send a body to the other."""
    for address, end in list(link.ends.items()):
        if sealed := end.seal_body(b"body"):
            link.put(sealed.datagram, address, sealed.address)
    link.settle()


def keep_alive(link: Link[CallSession], seconds: float) -> None:
    for _ in range(round(2 * seconds)):
        exchange(link)
        link.run(0.5)


def connected() -> tuple[Link[CallSession], CallSession, CallSession]:
    a, b = called(), calling(A)
    link = Link({A: a, B: b})
    link.run(1)
    assert a.session is not None and a.session == b.session
    return link, a, b


def assert_in_one_call(link: Link[CallSession]) -> None:
    """Both ends have the same session, and what one seals the other opens."""
    a, b = link.ends.values()
    assert a.session is not None and a.session == b.session
    before = len(link.bodies_of(a)), len(link.bodies_of(b))
    exchange(link)
    assert (len(link.bodies_of(a)), len(link.bodies_of(b))) == (before[0] + 1, before[1] + 1)


def test_one_end_calls_and_the_other_is_called() -> None:
    link, a, b = connected()
    assert_in_one_call(link)
    assert a.peer == B and b.peer == A
    assert a.sealed_bytes(20) == b.sealed_bytes(20) == 34
    assert not a.dropped and not b.dropped


def test_without_a_session_nothing_can_be_sealed() -> None:
    for end in (called(), calling(A)):
        assert end.session is end.peer is end.seal_body(b"body") is end.next_event() is None
        assert end.sealed_bytes(20) == 39
        end.acknowledge(0)


@pytest.mark.parametrize("who", range(2))
def test_both_ends_shorten_their_counters(who: int) -> None:
    _, *ends = connected()
    end = ends[who]
    for _ in range(200):
        end.seal_body(b"body")
    assert end.sealed_bytes(20) == 35
    end.acknowledge(199)
    assert end.sealed_bytes(20) == 34


@pytest.mark.slow
def test_if_both_call_at_once_the_larger_attempt_stays_initiator() -> None:
    for seed in range(6):
        a, b = calling(B, f"a {seed}"), calling(A, f"b {seed}")
        link = Link({A: a, B: b})
        attempts = [end._caller.initiator.attempt for end in (a, b) if end._caller and end._caller.initiator]
        link.run(1)
        assert_in_one_call(link)
        winner = a if attempts[0] > attempts[1] else b
        assert winner._caller and winner._caller.session is not None
        assert len([e for end in (a, b) for e in link.events_of(end) if isinstance(e, Connected)]) == 2


class Choices:
    """What the network does to the first datagrams: their delays, none if it loses them."""

    def __init__(self, delays: list[list[float]]) -> None:
        self._delays = iter(delays)

    def __call__(self, _data: bytes) -> Iterator[float]:
        yield from next(self._delays, [0.0])


NETWORK = st.lists(st.lists(st.sampled_from([0.0, 0.05, 0.1, 0.5, 2.0]), max_size=2), max_size=20)


@pytest.mark.slow
@settings(max_examples=60)
@given(NETWORK, st.integers(0, 5), st.sampled_from([0.0, 0.05, 0.1, 0.5]))
def test_of_two_calls_that_cross_one_session_results(delays: list[list[float]], seed: int, later: float) -> None:
    """Whatever is lost, delayed, overtaken and duplicated, and whoever begins first."""
    a, b = calling(B, f"a {seed}"), calling(A, f"b {seed}", BEGIN + later)
    link = Link({A: a, B: b}, delays=Choices(delays))
    for _ in range(60):
        keep_alive(link, 1)
        if a.session is not None and a.session == b.session and link.now > BEGIN + 10:
            break
    assert_in_one_call(link)
    changes = len(link.events_of(a))
    keep_alive(link, 10)
    assert len(link.events_of(a)) == changes, "the call lasts"


def test_a_stranger_without_the_code_stops_no_call() -> None:
    a, stranger = calling(B), CallSession("acorn-tulip-river-43", lambda n: b"\xff" * n, BEGIN, remote=A)
    link = Link({A: a, C: stranger})
    link.run(3)
    b = called()
    link.ends[B] = b
    link.run(5)
    assert a.session == b.session is not None


def test_a_call_is_accepted_by_an_end_whose_own_call_reaches_nobody() -> None:
    a, b = calling(C, "\xff"), calling(A)
    link = Link({A: a, B: b})
    link.run(2)
    assert_in_one_call(link)
    assert a.peer == B


def test_a_third_caller_is_told_that_the_line_is_busy() -> None:
    link, a, b = connected()
    third = calling(A, "third", link.now)
    link.ends[C] = third
    keep_alive(link, 20)
    refused = link.events_of(third)
    assert refused and all(isinstance(e, Refused) and e.refusal is Refusal.IN_CALL and e.wait_s for e in refused)
    assert third.session is None and a.session == b.session is not None and a.peer == B
    assert len(link.events_of(a)) == 1


@pytest.mark.slow
def test_who_calls_and_is_in_a_call_is_busy_too() -> None:
    link, _, b = connected()
    third = calling(B, "third", link.now)
    link.ends[C] = third
    keep_alive(link, 6)
    assert {e.refusal for e in link.events_of(third) if isinstance(e, Refused)} == {Refusal.IN_CALL}
    assert b.peer == A


@pytest.mark.parametrize(("address", "silence_s"), [((B[0], 40001), SILENCE_S), (C, OTHER_HOST_SILENCE_S)])
def test_a_caller_that_was_restarted_gets_its_call_back(address: Address, silence_s: float) -> None:
    link, a, _ = connected()
    del link.ends[B]
    again = calling(A, "again", link.now)
    link.ends[address] = again
    link.run(silence_s - 2)
    assert a.peer == B
    link.run(4)
    assert a.session is not None and a.session == again.session and a.peer == address
    assert [type(e) for e in link.events_of(a)] == [Connected, SessionEnded, Connected]
    assert link.events_of(a)[1] == SessionEnded(link.events_of(a)[0].session, LossReason.REPLACED)  # type: ignore[union-attr]


def test_an_end_that_waits_and_was_restarted_is_called_again() -> None:
    link, _, b = connected()
    link.ends[A] = called("again")
    keep_alive(link, 4)
    assert_in_one_call(link)
    assert [type(e) for e in link.events_of(b)] == [Connected, SessionEnded, Connected]


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [20, 40])
def test_after_an_outage_the_call_goes_on(seconds: int) -> None:
    link, _, _ = connected()
    link.unreachable = {A}
    keep_alive(link, seconds)
    link.unreachable = set()
    keep_alive(link, 6)
    assert_in_one_call(link)


@pytest.mark.slow
def test_both_call_again_after_an_outage_if_both_know_whom_to_call() -> None:
    link = Link({A: calling(B, "a"), B: calling(A, "b")})
    link.run(1)
    link.unreachable = {A}
    keep_alive(link, 40)
    assert all(end.session is None for end in link.ends.values())
    link.unreachable = set()
    keep_alive(link, 10)
    assert_in_one_call(link)


def test_a_call_that_was_hung_up_is_not_made_again_and_the_other_end_waits_on() -> None:
    link, a, b = connected()
    for end in (a, b):
        end.close(LossReason.HUNG_UP)
    link.run(10)
    assert a.session is b.session is None
    assert link.events_of(b)[-1] == SessionEnded(link.events_of(b)[0].session, LossReason.HUNG_UP)  # type: ignore[union-attr]
    link.ends[C] = calling(A, "third", link.now)
    link.run(1)
    assert a.peer == C


def test_junk_is_counted() -> None:
    link, a, b = connected()
    for data in (b"", b"\x93", b"\x93\x03", b"\x94\x03", bytes(20), b"\x93\x03\x01" + bytes(20), b"\x94" * 30):
        a.receive_datagram(data, C, link.now)
        b.receive_datagram(data, C, link.now)
    assert a.dropped.total() == b.dropped.total() == 7
    assert set(a.dropped) <= set(DropReason)
