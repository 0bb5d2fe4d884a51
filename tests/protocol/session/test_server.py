"""The receiver's sessions: handshake, roaming, replay, junk, limits, silence."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.session.client import SenderSession
from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.events import AddressChanged, BodyReceived, Connected, LossReason, SessionEnded, WrongCode
from conf.protocol.session.packet import VERSION, Kind, handshake_datagram, parse_datagram
from conf.protocol.session.responder import RETRIES_PER_SECOND
from conf.protocol.session.server import IDLE_S, LINGER_S, UNKNOWN_REPLIES_PER_SECOND, SessionServer
from tests.support.simulated_sessions import CODE, RECEIVER, SENDER, WRONG, World, at_once, seeded, state

ELSEWHERE = ("203.0.113.9", 40001)


@pytest.fixture
def world() -> World:
    world = World()
    world.add_sender()
    world.run(0.1)
    return world


def session_of(world: World) -> int:
    (session,) = world.receiver.sessions
    return session


def test_bodies_arrive_in_both_directions(world: World) -> None:
    world.send_body(b"motion")
    answer = world.receiver.seal_body(session_of(world), b"report")
    assert answer is not None and answer.address == SENDER
    world.send(answer.datagram, RECEIVER, SENDER)
    world.settle()
    assert world.bodies() == [b"motion"]
    assert world.bodies(SENDER) == [b"report"]
    assert world.events() == [Connected(session_of(world), SENDER)]
    assert BodyReceived(session_of(world), b"motion", SENDER, 0) in world.received[RECEIVER]


def test_an_exhausted_session_ends_with_its_reason(world: World) -> None:
    session = session_of(world)
    world.receiver.sessions[session].sealing_key.counter = 1 << 32
    assert world.receiver.seal_body(session, b"report") is None
    assert world.receiver.next_event() == SessionEnded(session, LossReason.EXHAUSTED)
    assert world.receiver.seal_body(session, b"report") is None
    assert world.receiver.next_event() is None


def test_a_datagram_of_the_receiver_s_own_direction_is_counted_as_such(world: World) -> None:
    answer = handshake_datagram(Kind.RETRY, bytes(8), bytes(8))
    world.receiver.receive_datagram(answer, SENDER, world.now)
    assert world.receiver.dropped == {DropReason.DIRECTION: 1}


def test_the_two_directions_have_different_keys(world: World) -> None:
    sealed = world.senders[SENDER].seal_body(b"motion")
    assert sealed is not None
    world.senders[SENDER].receive_datagram(sealed.datagram, RECEIVER, world.now)
    assert world.senders[SENDER].dropped == {DropReason.SEAL: 1}


def test_a_replayed_datagram_is_dropped_and_does_not_keep_a_session_alive(world: World) -> None:
    sealed = world.senders[SENDER].seal_body(b"motion")
    assert sealed is not None
    for _ in range(3):
        world.send(sealed.datagram, SENDER, RECEIVER)
    world.settle()
    assert world.bodies() == [b"motion"]
    assert world.receiver.dropped == {DropReason.REPLAYED: 2}
    del world.senders[SENDER]
    for _ in range(31):
        world.run(1.0)
        world.send(sealed.datagram, SENDER, RECEIVER)
    assert world.events()[-1] == SessionEnded(session_of_first(world), LossReason.IDLE)


def session_of_first(world: World) -> int:
    connected = world.events()[0]
    assert isinstance(connected, Connected)
    return connected.session


def test_a_newer_datagram_from_a_new_address_moves_the_session(world: World) -> None:
    old = world.senders[SENDER].seal_body(b"late")
    assert old is not None
    world.move_sender(SENDER, ELSEWHERE)
    world.send_body(b"moved", ELSEWHERE)
    world.settle()
    assert world.events()[-1] == AddressChanged(session_of(world), ELSEWHERE)
    world.send(old.datagram, SENDER, RECEIVER)
    world.settle()
    bodies = world.bodies()
    assert bodies[0] == b"moved" and bodies[1][:1] == b"\x0d" and bodies[2:] == [b"late"], "the probe was answered"
    assert world.events()[-1] == AddressChanged(session_of(world), ELSEWHERE)
    assert world.receiver.sessions[session_of(world)].address == ELSEWHERE


def test_a_copy_of_a_datagram_does_not_move_the_session(world: World) -> None:
    sealed = world.senders[SENDER].seal_body(b"motion")
    assert sealed is not None
    world.send(sealed.datagram, ELSEWHERE, RECEIVER)  # overtakes the original
    world.send(sealed.datagram, SENDER, RECEIVER)
    world.settle()
    assert world.receiver.sessions[session_of(world)].address == SENDER


@pytest.mark.slow
def test_several_senders_each_have_their_own_session() -> None:
    world = World()
    addresses = [("198.51.100.7", 40000 + n) for n in range(9)]
    for address in addresses:
        world.add_sender(address)
    world.run(5.0)
    assert len(world.receiver.sessions) == 9
    for address in addresses:
        world.send_body(str(address[1]).encode(), address)
    world.settle()
    got = {(event.address, event.body) for event in world.received[RECEIVER] if isinstance(event, BodyReceived)}
    assert got == {(address, str(address[1]).encode()) for address in addresses}


def test_silence_ends_a_session_and_makes_room() -> None:
    world = World(max_sessions=1)
    world.add_sender()
    world.run(0.1)
    session = session_of(world)
    del world.senders[SENDER]
    world.run(IDLE_S + 0.2)
    assert world.events() == [Connected(session, SENDER), SessionEnded(session, LossReason.IDLE)]
    world.add_sender(ELSEWHERE)
    world.run(0.1)
    assert len(world.receiver.sessions) == 1


def test_a_new_handshake_of_the_same_address_replaces_its_session() -> None:
    world = World(max_sessions=1)
    world.add_sender()
    world.run(0.1)
    first = session_of(world)
    world.senders[SENDER] = SenderSession(CODE, RECEIVER, seeded("restarted"), world.now)
    world.run(0.1)
    second = session_of(world)
    assert second != first
    expected = [Connected(first, SENDER), SessionEnded(first, LossReason.REPLACED), Connected(second, SENDER)]
    assert world.events() == expected


def test_close_ends_a_session_once(world: World) -> None:
    session = session_of(world)
    world.receiver.close(session)
    world.receiver.close(session)
    assert world.receiver.seal_body(session, b"") is None
    assert world.receiver.next_event() == SessionEnded(session, LossReason.CLOSED)
    assert world.receiver.next_event() is None


def test_what_arrives_soon_after_the_end_of_a_session_is_not_counted_as_dropped(world: World) -> None:
    sealed = [world.senders[SENDER].seal_body(b"bye") for _ in range(4)]
    first, second, third, late = (item.datagram for item in sealed if item)
    world.receiver.receive_datagram(first, SENDER, world.now)
    world.receiver.close(session_of(world))
    world.receiver.receive_datagram(second, SENDER, world.now)
    assert not world.receiver.dropped and not world.receiver.datagrams_to_send(world.now)
    damaged = third[:-1] + bytes((third[-1] ^ 1,))
    world.receiver.receive_datagram(damaged, SENDER, world.now)
    assert world.receiver.dropped == {DropReason.SEAL: 1}
    world.receiver.datagrams_to_send(world.now + LINGER_S)
    world.receiver.receive_datagram(late, SENDER, world.now + LINGER_S)
    assert world.receiver.dropped[DropReason.UNKNOWN_SESSION] == 1


@pytest.mark.slow
def test_a_wrong_code_is_reported_with_the_tries_left() -> None:
    world = World()
    for n in range(6):
        world.add_sender(("198.51.100.7", n), WRONG)
    world.run(0.1)
    tries = [event.tries_left for event in world.events() if isinstance(event, WrongCode)]
    assert tries == [4, 3, 2, 1, 0]
    addresses = {event.address for event in world.events() if isinstance(event, WrongCode)}
    assert addresses < {("198.51.100.7", n) for n in range(6)} and len(addresses) == 5
    assert not world.receiver.sessions


def test_replies_to_an_unknown_session_are_smaller_and_rate_limited(world: World) -> None:
    data = bytes((0x94, VERSION, (session_of(world) + 1) % 128, 0, 0xC4, 8)) + bytes(8)
    for _ in range(1000):
        world.receiver.receive_datagram(data, ELSEWHERE, world.now)
    answers = world.receiver.datagrams_to_send(world.now)
    assert len(answers) == UNKNOWN_REPLIES_PER_SECOND
    assert all(len(answer) < len(data) for answer, _ in answers)
    assert world.receiver.dropped == {DropReason.UNKNOWN_SESSION: 1000}


def test_a_flood_of_hellos_gets_few_answers_and_leaves_no_state(world: World) -> None:
    before = state(world.receiver)
    answered = 0
    for n in range(5000):
        hello = handshake_datagram(Kind.HELLO, n.to_bytes(8), bytes(8), bytes(32))
        world.receiver.receive_datagram(hello, (f"10.0.{n % 256}.1", n), world.now)
        answers = world.receiver.datagrams_to_send(world.now)
        answered += len(answers)
        assert all(len(answer) <= len(hello) for answer, _ in answers)
    assert answered <= RETRIES_PER_SECOND
    assert state(world.receiver) == before
    assert world.receiver.dropped[DropReason.RATE] == 5000 - answered


@pytest.mark.slow
@given(st.data())
def test_corrupted_mutated_and_random_datagrams_change_nothing(data: st.DataObject) -> None:
    """Variations of intercepted datagrams cause no exception, no event, no larger answer and no change."""
    world = World()
    world.add_sender()
    world.run(0.1)
    for n in range(3):
        world.send_body(b"body %d" % n)
    world.settle()
    intercepted = [d for _, _, d in world.traffic]
    before = {side: state(side) for side in (world.receiver, world.senders[SENDER])}
    for _ in range(10):
        junk = data.draw(st.binary(max_size=64) | mutations(intercepted))
        for side in (world.receiver, world.senders[SENDER]):
            side.receive_datagram(junk, SENDER, world.now)
            answers = side.datagrams_to_send(world.now)
            assert sum(len(answer) for answer, _ in answers) <= len(junk)
            assert side.next_event() is None
            assert state(side) == before[side]
    world.send_body(b"good")
    world.settle()
    assert world.bodies()[-1] == b"good"
    assert state(world.receiver) != before[world.receiver]


def mutations(datagrams: list[bytes]) -> st.SearchStrategy[bytes]:
    """Return datagrams with one to four bits flipped, cut or extended; never one of the originals."""

    @st.composite
    def mutated(draw: st.DrawFn) -> bytes:
        data = bytearray(draw(st.sampled_from(datagrams)))
        for _ in range(draw(st.integers(1, 4))):
            bit = draw(st.integers(0, 8 * len(data) - 1))
            data[bit // 8] ^= 1 << bit % 8
        end = draw(st.integers(0, len(data)) | st.just(len(data)))
        result = bytes(data[:end]) + draw(st.just(b"") | st.binary(max_size=4))
        return b"" if result in datagrams else result

    return mutated()


@pytest.mark.slow
def test_every_single_bit_of_every_datagram_of_a_handshake_may_flip() -> None:
    """A damaged copy arrives before each good datagram: it connects all the same, and no try is used up."""
    clean = World()
    clean.add_sender()
    clean.run(0.1)
    for index in range(len(clean.traffic)):
        for bit in range(8 * len(clean.traffic[index][2])):
            if bit % 21 == index % 21:  # one of 21 bits, to save time
                world = FlipWorld(index, bit)
                world.add_sender()
                world.run(0.1)
                assert world.senders[SENDER].session is not None
                assert not any(isinstance(event, WrongCode) for event in world.events())


class FlipWorld(World):
    """Deliver a copy of one datagram with one bit flipped before the datagram itself."""

    def __init__(self, index: int, bit: int) -> None:
        super().__init__()
        self._index, self._bit = index, bit

    def send(self, data: bytes, source: tuple[str, int], target: tuple[str, int]) -> None:  # type: ignore[override]
        if len(self.traffic) == self._index:
            damaged = bytearray(data)
            damaged[self._bit // 8] ^= 1 << self._bit % 8
            super().send(bytes(damaged), source, target)
        super().send(data, source, target)


@pytest.mark.slow
@given(st.binary(min_size=1, max_size=60))
def test_the_parser_raises_only_datagram_errors(data: bytes) -> None:
    receiver = SessionServer(CODE, seeded("r"))
    receiver.receive_datagram(data, SENDER, 0.0)
    try:
        parse_datagram(data)
    except DatagramError:
        assert receiver.dropped.total() == 1


def test_keys_change_on_both_sides_without_a_message_and_under_loss() -> None:
    world = World(epoch_length=8)
    world.add_sender(epoch_length=8)
    world.run(0.1)
    sent = []
    for n in range(100):
        sent.append(b"body %d" % n)
        world.delays = at_once if n % 3 else lambda _: []
        world.send_body(sent[-1])
        world.settle()
    assert world.bodies() == [body for n, body in enumerate(sent) if n % 3]
    assert not world.receiver.dropped


@pytest.mark.slow
def test_a_flood_of_spoofed_hellos_does_not_delay_a_hello_with_a_cookie(world: World) -> None:
    late = world.add_sender(ELSEWHERE)
    for data, _ in late.datagrams_to_send(world.now):
        world.receiver.receive_datagram(data, ELSEWHERE, world.now)
    for data, _ in world.receiver.datagrams_to_send(world.now):
        late.receive_datagram(data, RECEIVER, world.now)
    for n in range(1000):
        hello = handshake_datagram(Kind.HELLO, n.to_bytes(8), bytes(8), bytes(32))
        world.receiver.receive_datagram(hello, ("10.0.0.1", n), world.now)
    assert world.receiver.dropped[DropReason.RATE]
    world.settle()
    assert late.session in world.receiver.sessions


def test_max_sessions_is_limited_by_the_session_numbers() -> None:
    with pytest.raises(ValueError, match="max_sessions must be from 1 to 127"):
        SessionServer(CODE, seeded("r"), max_sessions=128)
    SessionServer(CODE, seeded("r"), max_sessions=127)


@pytest.mark.slow
def test_session_numbers_wrap_and_skip_those_in_use(world: World) -> None:
    taken = session_of(world)
    world.receiver._next_session = taken
    numbers = []
    for port in range(3):
        numbers.append(world.add_sender(("198.51.100.8", port)))
        world.run(0.1)
        if port == 0:
            world.receiver._next_session = 127
    sessions = [sender.session for sender in numbers]
    assert sessions == [(taken + 1) % 128, 127, 0]
