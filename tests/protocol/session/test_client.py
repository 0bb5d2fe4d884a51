"""The sender's session: it connects over any network that delivers anything, and reconnects by itself."""

import random
from collections.abc import Callable, Iterable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.address import Address
from conf.protocol.session.client import IDLE_S, SILENCE_S
from conf.protocol.session.drop_reasons import DropReason
from conf.protocol.session.events import BodyReceived, Connected, LossReason, NoAnswer, Refused, SessionEnded, WrongCode
from conf.protocol.session.handshake import Refusal
from conf.protocol.session.initiator import CONFIRM_TIMEOUT_S
from conf.protocol.session.packet import VERSION, Kind, handshake_datagram
from tests.support.simulated_sessions import RECEIVER, SENDER, WRONG, World, at_once, lose_all

# For each of the first datagrams the delays of the copies that arrive. Later datagrams arrive.
DELAYS = st.lists(st.lists(st.sampled_from([0.0, 0.1, 0.3, 1.0, 3.0]), max_size=3), max_size=24)


def listed(delays: list[list[float]]) -> Callable[[bytes], Iterable[float]]:
    rest = iter(delays)
    return lambda _: next(rest, [0.0])


def connected() -> World:
    world = World()
    world.add_sender()
    world.run(0.1)
    assert world.senders[SENDER].session is not None
    return world


def exchange_bodies(world: World, seconds: float) -> None:
    """Send a body and a report twice a second, as a call does."""
    for _ in range(int(seconds / 0.5)):
        world.run(0.5)
        for session in list(world.receiver.sessions):
            report = world.receiver.seal_body(session, b"report")
            assert report is not None
            world.send(report.datagram, RECEIVER, report.address)
        for address, sender in world.senders.items():
            if sender.session is not None:
                world.send_body(b"motion", address)
        world.settle()


@pytest.mark.slow
@given(DELAYS)
def test_it_connects_despite_loss_duplication_and_reordering(delays: list[list[float]]) -> None:
    world = World(listed(delays))
    sender = world.add_sender()
    world.run_until(lambda: sender.session in world.receiver.sessions, 90.0)
    world.delays = at_once
    world.send_body(b"motion")
    world.settle()
    assert world.bodies() == [b"motion"]
    assert not any(isinstance(event, WrongCode) for event in world.events())


@pytest.mark.slow
@given(DELAYS)
def test_a_wrong_code_never_connects_and_is_reported_on_both_sides(delays: list[list[float]]) -> None:
    world = World(listed(delays))
    sender = world.add_sender(code=WRONG)
    world.run_until(lambda: sender.stopped, 90.0)
    assert sender.session is None and not world.receiver.sessions
    assert sum(isinstance(event, WrongCode) for event in world.events(SENDER)) == 1
    assert any(event == WrongCode(4, SENDER) for event in world.events())
    assert sender.seal_body(b"") is None


def test_the_sizes_of_the_handshake_datagrams() -> None:
    world = connected()
    assert [len(data) for _, _, data in world.traffic] == [57, 25, 57, 49, 34, 34]


def test_a_full_receiver_is_reported_and_final() -> None:
    world = World(max_sessions=1)
    world.add_sender()
    world.run(0.1)
    late = ("198.51.100.8", 1)
    sender = world.add_sender(late)
    world.run(0.1)
    assert world.events(late) == [Refused(Refusal.FULL, None)]
    assert sender.stopped


@pytest.mark.slow
def test_a_locked_receiver_is_tried_again_after_its_wait() -> None:
    world = World()
    for n in range(5):
        world.add_sender(("198.51.100.9", n), WRONG)
    world.run(0.5)
    sender = world.add_sender()
    world.run(1.0)
    refused = world.events(SENDER)[0]
    assert isinstance(refused, Refused) and refused.refusal is Refusal.LOCKED and refused.wait_s
    assert 55 < refused.wait_s <= 60
    sent = len(world.traffic)
    world.run(50.0)
    assert len(world.traffic) == sent
    world.run(12.0)
    assert sender.session in world.receiver.sessions


def test_no_answer_is_reported_once_and_tried_on() -> None:
    world = World(lose_all)
    sender = world.add_sender()
    world.run(40.0)
    (event,) = world.events(SENDER)
    assert isinstance(event, NoAnswer) and event.seconds == pytest.approx(5.0, abs=0.2)
    world.delays = at_once
    world.run(5.0)
    assert sender.session is not None


@pytest.mark.slow
def test_a_restarted_receiver_with_the_same_code_is_found_again() -> None:
    world = connected()
    exchange_bodies(world, 5.0)
    first = world.senders[SENDER].session
    world.restart_receiver()
    at = world.now
    exchange_bodies(world, 4.0)
    assert world.senders[SENDER].session in world.receiver.sessions
    assert SessionEnded(first, LossReason.REPLACED) in world.events(SENDER)  # type: ignore[arg-type]
    assert world.bodies()[-1] == b"motion"
    assert world.now - at <= 4.1


@pytest.mark.slow
@pytest.mark.parametrize("replies", [True, False])
def test_two_restarts_with_and_without_the_unknown_session_reply(replies: bool) -> None:
    world = connected()
    world.delays = lambda data: [0.0] if replies or data[:3] != b"\x93\x03\x06" else []
    for seed in ("second", "third"):
        exchange_bodies(world, 3.0)
        world.restart_receiver(seed)
        exchange_bodies(world, SILENCE_S + 2.0)
        assert world.senders[SENDER].session in world.receiver.sessions


@pytest.mark.slow
def test_a_receiver_restarted_with_another_code_ends_the_session() -> None:
    world = connected()
    exchange_bodies(world, 2.0)
    world.restart_receiver(code=WRONG)
    exchange_bodies(world, IDLE_S + 5.0)
    reported = [event for event in world.events(SENDER) if not isinstance(event, Connected)]
    assert reported == [WrongCode(4, RECEIVER), SessionEnded(reported[1].session, LossReason.IDLE)]  # type: ignore[union-attr]


def test_a_forged_unknown_session_reply_cannot_end_a_session() -> None:
    world = connected()
    sender = world.senders[SENDER]
    exchange_bodies(world, 2.0)
    session = sender.session
    assert session is not None
    forged = handshake_datagram(Kind.UNKNOWN, session)
    sender.receive_datagram(forged, RECEIVER, world.now)
    world.run(0.1)
    assert not any(data[0] == 0x93 for _, _, data in world.traffic[6:])
    world.delays = lose_all
    world.run(1.5)
    sender.receive_datagram(forged, RECEIVER, world.now)
    world.run(2.0)
    assert sender.session == session
    world.delays = at_once
    exchange_bodies(world, 3.0)
    assert sender.session in world.receiver.sessions
    assert len(world.receiver.sessions) == 1


def test_an_outage_shorter_than_the_idle_time_keeps_a_session() -> None:
    world = connected()
    exchange_bodies(world, 2.0)
    session = world.senders[SENDER].session
    world.delays = lose_all
    exchange_bodies(world, 20.0)
    world.delays = at_once
    exchange_bodies(world, 9.0)
    assert list(world.receiver.sessions) == [session]
    assert world.senders[SENDER].session in world.receiver.sessions
    assert not any(isinstance(e, SessionEnded) and e.reason is LossReason.IDLE for e in world.events())


@pytest.mark.slow
def test_a_false_receiver_gets_at_most_three_proofs_a_minute() -> None:
    """It refuses or ignores each proof in order to get another guess."""
    for refusal in (None, Refusal.BUSY, Refusal.LOCKED):
        world = World()
        world.add_sender(code=WRONG)
        proofs: set[bytes] = set()

        def delays(data: bytes, proofs: set[bytes] = proofs, refusal: Refusal | None = refusal) -> list[float]:
            if data[2] == Kind.CONFIRM:
                proofs.add(data)
                if refusal is not None:
                    world.send(handshake_datagram(Kind.REFUSED, data[5:13], refusal, 0), RECEIVER, SENDER)  # noqa: B023
                return []
            return [0.0]

        world.delays = delays
        world.run(60.0)
        assert 2 <= len(proofs) <= 60 / CONFIRM_TIMEOUT_S


@pytest.mark.slow
def test_a_silent_session_ends_and_is_renewed_when_the_receiver_answers() -> None:
    world = connected()
    sender = world.senders[SENDER]
    world.delays = lose_all
    world.run(IDLE_S + 1.0)
    assert sender.session is None
    kinds = [type(event) for event in world.events(SENDER)]
    assert kinds == [Connected, SessionEnded, NoAnswer]
    world.delays = at_once
    world.run(5.0)
    assert sender.session is not None


def test_counters_are_short_once_acknowledged() -> None:
    world = connected()
    sender = world.senders[SENDER]
    for _ in range(200):
        sealed = sender.seal_body(b"")
    assert sealed is not None and len(sealed.datagram) == 15
    sender.acknowledge(sealed.counter)
    assert len(sender.seal_body(b"").datagram) == 14  # type: ignore[union-attr]


@pytest.mark.slow
def test_an_exhausted_session_is_followed_by_a_new_one() -> None:
    world = connected()
    sender = world.senders[SENDER]
    assert sender._active is not None
    sender._active.sealing_key.counter = 1 << 32
    assert sender.seal_body(b"motion") is None
    world.run(0.2)
    assert [type(event) for event in world.events(SENDER)] == [Connected, SessionEnded, Connected]
    world.send_body(b"motion")
    world.settle()
    assert world.bodies() == [b"motion"]


def test_datagrams_of_no_handshake_and_no_session_are_counted() -> None:
    world = connected()
    sender = world.senders[SENDER]
    sender.receive_datagram(handshake_datagram(Kind.RETRY, bytes(8), bytes(8)), RECEIVER, world.now)
    sender.receive_datagram(
        bytes((0x94, VERSION, (sender.session or 0) ^ 1, 0, 0xC4, 8)) + bytes(8), RECEIVER, world.now
    )
    assert sender.dropped == {DropReason.UNKNOWN_ATTEMPT: 1, DropReason.UNKNOWN_SESSION: 1}


TROUBLES = st.lists(
    st.tuples(
        st.sampled_from(["restart", "roam", "outage", "one way", "other way", "half lost", "fine"]), st.integers(1, 12)
    ),
    max_size=6,
)


@pytest.mark.slow
@given(TROUBLES)
def test_after_any_trouble_bodies_arrive_again(troubles: list[tuple[str, int]]) -> None:
    world = connected()
    address: Address = SENDER
    for number, (trouble, half_seconds) in enumerate(troubles):
        if trouble == "restart":
            world.restart_receiver(f"restart {number}")
        if trouble == "roam":
            moved = ("203.0.113.9", number)
            world.move_sender(address, moved)
            address = moved
        world.delays = half_lost(number) if trouble == "half lost" else at_once
        unreachable: dict[str, set[Address]] = {
            "outage": {RECEIVER, address},
            "one way": {RECEIVER},
            "other way": {address},
        }
        world.unreachable = unreachable.get(trouble, set())
        exchange_bodies(world, half_seconds / 2)
    world.delays, world.unreachable = at_once, set()
    exchange_bodies(world, CONFIRM_TIMEOUT_S + SILENCE_S + 4.0)
    sender = world.senders[address]
    assert sender.session in world.receiver.sessions
    world.send_body(b"last", address)
    world.settle()
    assert world.bodies()[-1] == b"last"
    assert not any(isinstance(event, WrongCode | Refused) for event in world.events(address) + world.events())


def half_lost(seed: int) -> Callable[[bytes], list[float]]:
    numbers = random.Random(seed)
    return lambda _: [0.0] if numbers.random() < 0.5 else []


@pytest.mark.parametrize(("silence_s", "number", "is_tried"), [(0.9, 0, False), (1.0, 0, True), (1.0, 1, False)])
def test_an_unknown_session_reply_starts_a_handshake_after_a_second_of_silence(
    silence_s: float, number: int, is_tried: bool
) -> None:
    world = connected()
    exchange_bodies(world, 1.0)
    sender, last = world.senders[SENDER], world.now
    assert sender.session is not None
    reply = handshake_datagram(Kind.UNKNOWN, (sender.session + number) % 128)
    sender.receive_datagram(reply, RECEIVER, last + silence_s)
    datagrams = sender.datagrams_to_send(last + silence_s)
    assert [data[2] for data, _ in datagrams] == ([Kind.HELLO] if is_tried else [])
    assert sender.dropped.total() == number


def test_an_unknown_session_reply_without_a_session_is_dropped() -> None:
    world = World(lose_all)
    sender = world.add_sender()
    sender.receive_datagram(handshake_datagram(Kind.UNKNOWN, 5), RECEIVER, world.now)
    assert sender.dropped == {DropReason.UNKNOWN_SESSION: 1}


def test_a_received_body_is_an_event() -> None:
    world = connected()
    exchange_bodies(world, 1.0)
    assert world.bodies(SENDER) == [b"report", b"report"]
    events = [event for event in world.received[SENDER] if isinstance(event, BodyReceived)]
    assert [(event.session, event.address, event.counter) for event in events] == [
        (world.senders[SENDER].session, RECEIVER, counter) for counter in range(2)
    ]


def test_silence_of_a_session_starts_a_handshake_after_four_seconds() -> None:
    world = connected()
    exchange_bodies(world, 1.0)
    sender, last = world.senders[SENDER], world.now
    assert sender.datagrams_to_send(last + SILENCE_S - 0.01) == []
    assert len(sender.datagrams_to_send(last + SILENCE_S)) == 1


def test_a_session_ends_after_half_a_minute_of_silence() -> None:
    world = connected()
    exchange_bodies(world, 1.0)
    sender, last = world.senders[SENDER], world.now
    sender.datagrams_to_send(last + IDLE_S - 0.01)
    assert sender.session is not None
    sender.datagrams_to_send(last + IDLE_S)
    assert sender.session is None
