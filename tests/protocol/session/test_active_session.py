"""An established session: both directions of the seal, and where datagrams go while the peer moves."""

import pytest

from conf.protocol.address import Address
from conf.protocol.session.active_session import FAREWELL_INTERVAL_S, LEAVING_S, ActiveSession, ClosedSession
from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.events import AddressChanged, BodyReceived
from conf.protocol.session.packet import DataPacket, parse_datagram
from conf.protocol.session.paths.validation import PER_SECOND, TOKEN_BYTES
from conf.protocol.session.seal import CounterExhausted
from tests.support.simulated_sessions import seeded

SECRETS = bytes(32), bytes([1]) * 32
A: Address = ("192.0.2.1", 5005)
B: Address = ("198.51.100.7", 40000)
NEW_A: Address = ("192.0.2.77", 5005)
NEW_B: Address = ("198.51.100.77", 40001)
ATTACKER: Address = ("203.0.113.9", 9)


def pair() -> tuple[ActiveSession, ActiveSession]:
    a = ActiveSession(7, SECRETS, B, 5.0, random=seeded("a"))
    b = ActiveSession(7, SECRETS[::-1], A, 5.0, random=seeded("b"))
    return a, b


def receive(
    session: ActiveSession, datagram: bytes, address: Address, now: float = 5.0
) -> list[AddressChanged | BodyReceived]:
    packet = parse_datagram(datagram)
    assert isinstance(packet, DataPacket)
    return session.receive(packet, address, now)


def test_what_one_side_seals_the_other_opens_once() -> None:
    a, b = pair()
    for counter in range(2):
        sealed = a.seal(b"body")
        assert (sealed.address, sealed.counter) == (B, counter)
        assert receive(b, sealed.datagram, A, 6.0) == [BodyReceived(7, b"body", A, counter)]
        assert b.last_received == 6.0
        with pytest.raises(DatagramError) as caught:
            receive(b, sealed.datagram, A, 7.0)
        assert caught.value.reason is DropReason.REPLAYED and b.last_received == 6.0
    assert a.datagrams_to_send(5.0)[0] == b.datagrams_to_send(5.0)[0] == []


def test_a_session_moves_when_the_probe_of_a_new_address_is_answered() -> None:
    a, b = pair()
    assert receive(a, b.seal(b"body").datagram, NEW_B) == [BodyReceived(7, b"body", NEW_B, 0)]
    assert a.address == B, "not yet"
    ((probe, target),) = a.datagrams_to_send(5.0)[0]
    assert target == NEW_B and len(probe) < 24
    receive(b, probe, A)
    ((answer, target),) = b.datagrams_to_send(5.0)[0]
    assert target == A and len(answer) == len(probe)
    changed, received = receive(a, answer, NEW_B)
    assert changed == AddressChanged(7, NEW_B) and isinstance(received, BodyReceived)
    assert a.address == a.seal(b"body").address == NEW_B
    assert a.datagrams_to_send(5.0)[0] == b.datagrams_to_send(5.0)[0] == []


def test_a_copy_that_overtakes_the_original_moves_nothing() -> None:
    a, b = pair()
    for number in range(100):
        now = 5.0 + number / 10
        sealed = b.seal(b"body")
        receive(a, sealed.datagram, ATTACKER, now)
        with pytest.raises(DatagramError):
            receive(a, sealed.datagram, B, now)
        assert a.seal(b"body").address == B
        assert {target for _, target in a.datagrams_to_send(5.0)[0]} <= {ATTACKER}


def test_a_copy_that_arrives_late_causes_no_probe() -> None:
    a, b = pair()
    first, second = b.seal(b"1"), b.seal(b"2")
    receive(a, second.datagram, B)
    receive(a, first.datagram, ATTACKER)
    assert a.datagrams_to_send(5.0)[0] == []


def test_while_somebody_copies_a_real_move_is_found_too() -> None:
    a, b = pair()
    receive(a, b.seal(b"body").datagram, ATTACKER)
    receive(a, b.seal(b"body").datagram, NEW_B)
    probes = a.datagrams_to_send(5.0)[0]
    assert [target for _, target in probes] == [ATTACKER, NEW_B]
    receive(b, probes[1][0], A)
    ((answer, _),) = b.datagrams_to_send(5.0)[0]
    receive(a, answer, NEW_B)
    assert a.address == NEW_B


def test_both_ends_may_move_at_once() -> None:
    a, b = pair()
    from_a, from_b = a.seal(b"a").datagram, b.seal(b"b").datagram
    receive(a, from_b, NEW_B)
    receive(b, from_a, NEW_A)
    for _ in range(2):  # probes, then answers
        sent = [(b, NEW_A, a.datagrams_to_send(5.0)[0]), (a, NEW_B, b.datagrams_to_send(5.0)[0])]
        for receiver, source, datagrams in sent:
            for data, target in datagrams:
                assert target == (NEW_B if receiver is b else NEW_A)
                receive(receiver, data, source)
    assert a.address == NEW_B and b.address == NEW_A


def test_a_flood_of_probes_is_answered_a_few_times_a_second() -> None:
    a, b = pair()
    answers = 0
    for number in range(1000):
        receive(a, b.seal(b"\x0c" + bytes(TOKEN_BYTES)).datagram, B, 5.0 + number / 1000)
        answers += len(a.datagrams_to_send(5.0)[0])
    assert PER_SECOND <= answers <= 2 * PER_SECOND


def test_an_answer_with_another_token_or_of_another_size_moves_nothing() -> None:
    a, b = pair()
    receive(a, b.seal(b"body").datagram, NEW_B)
    (_, _) = a.datagrams_to_send(5.0)[0][0]
    for body in (b"\x0d" + bytes(TOKEN_BYTES), b"\x0d", b"\x0c" + bytes(TOKEN_BYTES + 1)):
        receive(a, b.seal(body).datagram, B)
        assert a.address == B
    assert a.datagrams_to_send(5.0)[0] == []


def test_after_the_last_counter_no_probe_is_sent() -> None:
    a, b = pair()
    a.sealing_key.counter = 1 << 32
    with pytest.raises(CounterExhausted):
        a.seal(b"body")
    receive(a, b.seal(b"body").datagram, NEW_B)
    assert a.datagrams_to_send(5.0)[0] == []


def opened(closed: ClosedSession, datagrams: list[tuple[bytes, Address]]) -> None:
    for datagram, _ in datagrams:
        packet = parse_datagram(datagram)
        assert isinstance(packet, DataPacket)
        closed.receive(packet)


def test_a_farewell_is_repeated_until_it_is_answered() -> None:
    a, b = pair()
    leaving, left = ClosedSession(a, farewell=b"bye"), ClosedSession(b, farewell=b"bye", is_left=True)
    assert leaving.is_leaving(5.0) and leaving.datagrams_to_send(5.0) == [], "the owner has sent one"
    assert [address for _, address in leaving.datagrams_to_send(5.0 + FAREWELL_INTERVAL_S)] == [B]
    answer = left.datagrams_to_send(5.2)
    assert [address for _, address in answer] == [A] and left.datagrams_to_send(9.0) == []
    opened(leaving, answer)
    assert not leaving.is_leaving(5.3) and leaving.datagrams_to_send(6.0) == []


def test_every_farewell_is_answered_and_no_answer_is() -> None:
    a, b = pair()
    leaving, left = ClosedSession(a, farewell=b"bye"), ClosedSession(b, farewell=b"bye", is_left=True)
    leaving.datagrams_to_send(5.0)
    left.datagrams_to_send(5.0)  # lost
    opened(left, leaving.datagrams_to_send(5.0 + FAREWELL_INTERVAL_S))
    opened(leaving, left.datagrams_to_send(5.0 + FAREWELL_INTERVAL_S))
    assert leaving.datagrams_to_send(5.5) == left.datagrams_to_send(5.5) == []


def test_who_leaves_gives_up_but_answers_a_peer_that_goes_on() -> None:
    a, b = pair()
    leaving = ClosedSession(a, farewell=b"bye")
    times = [5.0 + i * 0.05 for i in range(60)]
    sent = [at for at in times if leaving.datagrams_to_send(at)]
    assert len(sent) in (5, 6) and sent[-1] < 5.0 + LEAVING_S and not leaving.is_leaving(5.0 + LEAVING_S)
    opened(leaving, [(b.seal(b"motion").datagram, A)])
    assert len(leaving.datagrams_to_send(8.0)) == 1 and leaving.datagrams_to_send(8.5) == []


def test_without_a_farewell_a_closed_session_is_silent() -> None:
    a, b = pair()
    closed = ClosedSession(a)
    opened(closed, [(b.seal(b"motion").datagram, A)])
    assert not closed.is_leaving(5.0) and closed.datagrams_to_send(6.0) == []
