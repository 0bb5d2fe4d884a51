"""The receiver against strangers: bounded work, small answers, five wrong codes a minute, nothing counted twice."""

import pytest

from conf.protocol.address import Address
from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.flood_protection import MAX_WRONG_CODES
from conf.protocol.session.handshake import Refusal, proof, sender_secrets, sender_share
from conf.protocol.session.packet import FIELDS, HandshakePacket, Kind, parse_datagram
from conf.protocol.session.responder import (
    ANSWER_BURST,
    ATTEMPT_LIFE_S,
    MAX_ATTEMPTS_PER_HOST,
    RETRIES_PER_SECOND,
    Attempt,
    Responder,
    _refused,
)
from tests.support.simulated_sessions import CODE, SENDER, WRONG, seeded

ELSEWHERE: Address = ("203.0.113.9", 40001)


class Caller:
    """A sender controlled by the test."""

    def __init__(self, responder: Responder, name: int, code: str = CODE, address: Address = SENDER) -> None:
        self.responder = responder
        self.address = address
        self.name = name.to_bytes(8)
        self.spake, self.share = sender_share(code, seeded(name))

    def hello(self, now: float, cookie: bytes = bytes(8)) -> HandshakePacket:
        return read(self.responder.hello((self.name, cookie, self.share), self.address, now))

    def hello_twice(self, now: float) -> HandshakePacket:
        return self.hello(now, self.hello(now).fields[1])

    def confirm(self, answer: HandshakePacket, now: float) -> tuple[HandshakePacket, int | None]:
        secrets = sender_secrets(self.spake, self.name, (self.share, answer.fields[1]))
        data, left = self.responder.confirm((self.name, 0, proof(secrets.sender_proof, 0)), self.address, now)
        return read(data), left


def read(data: bytes) -> HandshakePacket:
    packet = parse_datagram(data)
    assert isinstance(packet, HandshakePacket)
    return packet


def responder(*, room: bool = True) -> Responder:
    return Responder(
        CODE, seeded("responder"), refuse=lambda *_: None if room else (Refusal.FULL, 0), accept=lambda *_: 5
    )


def test_no_answer_is_larger_than_its_request() -> None:
    size = {kind: fields.size for kind, fields in FIELDS.items()}
    assert max(size[Kind.RETRY], size[Kind.ANSWER], size[Kind.REFUSED]) <= size[Kind.HELLO]
    assert max(size[Kind.DONE], size[Kind.REFUSED]) <= size[Kind.CONFIRM]
    assert 5 + size[Kind.UNKNOWN] + 4 <= 14


@pytest.mark.slow
def test_a_hello_without_a_cookie_leaves_no_state() -> None:
    side = responder()
    for name in range(100):
        assert Caller(side, name).hello(0.0).kind is Kind.RETRY
    assert not side.attempts


def test_a_repeated_datagram_gets_the_same_answer() -> None:
    side = responder()
    caller = Caller(side, 1)
    answer = caller.hello_twice(0.0)
    assert answer.kind is Kind.ANSWER
    assert caller.hello(0.0) == caller.hello(29.0) == answer
    done = caller.confirm(answer, 1.0)
    assert done[0].kind is Kind.DONE
    assert caller.confirm(answer, 2.0) == done


def test_the_server_is_asked_with_the_secrets_and_the_address_of_the_confirm() -> None:
    asked: list[tuple[object, ...]] = []
    rooms: list[Address] = []

    def refuse(address: Address, _now: float) -> None:
        rooms.append(address)

    def accept(attempt: Attempt, address: Address, now: float) -> int:
        asked.append((attempt.secrets, address, now))
        return 5

    caller = Caller(Responder(CODE, seeded("responder"), refuse=refuse, accept=accept), 1)
    answer = caller.hello_twice(0.5)
    expected = sender_secrets(caller.spake, caller.name, (caller.share, answer.fields[1]))
    caller.address = ELSEWHERE
    assert caller.confirm(answer, 1.5)[0].fields[1] == 5
    assert rooms == [SENDER]
    assert asked == [(expected, ELSEWHERE, 1.5)]


def test_a_confirm_of_no_attempt_is_counted_as_such() -> None:
    with pytest.raises(DatagramError) as caught:
        responder().confirm((bytes(8), 0, bytes(16)), SENDER, 0.0)
    assert caught.value.reason is DropReason.UNKNOWN_ATTEMPT


def test_a_wrong_code_is_counted_once_and_reported() -> None:
    side = responder()
    caller = Caller(side, 1, WRONG)
    answer = caller.hello_twice(0.0)
    refused, left = caller.confirm(answer, 0.0)
    assert refused.fields[1:] == (Refusal.WRONG_CODE, 4)
    assert left == 4
    assert caller.confirm(answer, 1.0) == (refused, None)
    assert side.limit.tries_left(1.0) == 4


@pytest.mark.slow
def test_after_five_wrong_codes_no_proof_is_checked_for_the_rest_of_the_minute() -> None:
    side = responder()
    callers = [Caller(side, name, WRONG if name < 6 else CODE) for name in range(7)]
    answers = [caller.hello_twice(0.0) for caller in callers]
    for tries, (caller, answer) in enumerate(zip(callers[:5], answers, strict=False)):
        assert caller.confirm(answer, 0.0)[1] == MAX_WRONG_CODES - 1 - tries
    for caller, answer in zip(callers[5:], answers[5:], strict=True):
        assert caller.confirm(answer, 20.5)[0].fields[1:] == (Refusal.LOCKED, 40)
    assert Caller(side, 8).hello_twice(20.5).fields[1:] == (Refusal.LOCKED, 40)
    right = Caller(side, 9)
    assert right.confirm(right.hello_twice(60.0), 60.0)[0].kind is Kind.DONE


@pytest.mark.slow
def test_curve_work_is_rate_limited() -> None:
    side = responder()
    kinds = [Caller(side, n, address=(f"host{n}", 1)).hello_twice(0.0).kind for n in range(20)]
    assert kinds.count(Kind.ANSWER) == ANSWER_BURST
    assert Caller(side, 99, address=("host99", 1)).hello_twice(1.0).kind is Kind.ANSWER


@pytest.mark.slow
def test_one_host_cannot_use_all_attempts() -> None:
    side = responder()
    kinds = [Caller(side, n, address=("host", n)).hello_twice(10.0 * (n > 7)).kind for n in range(10)]
    assert kinds == [Kind.ANSWER] * MAX_ATTEMPTS_PER_HOST + [Kind.REFUSED] * 2
    assert Caller(side, 99).hello_twice(10.0).kind is Kind.ANSWER


@pytest.mark.slow
def test_the_number_of_attempts_is_limited_and_they_expire() -> None:
    side = responder()
    answered = 0
    for n in range(200):
        answered += Caller(side, n, address=(f"host{n}", 1)).hello_twice(n / 10).kind is Kind.ANSWER
        assert len(side.attempts) <= 32
    assert answered == 32
    assert Caller(side, 999).hello_twice(19.9 + ATTEMPT_LIFE_S).kind is Kind.ANSWER
    assert len(side.attempts) == 1


def test_a_full_receiver_refuses_without_curve_work() -> None:
    assert Caller(responder(room=False), 1).hello_twice(0.0).fields[1:] == (Refusal.FULL, 0)


def test_another_share_or_address_with_a_known_attempt_changes_nothing() -> None:
    side = responder()
    caller, thief = Caller(side, 1), Caller(side, 1, address=("elsewhere", 1))
    thief.spake, thief.share = sender_share(CODE, seeded("thief"))
    answer = caller.hello_twice(0.0)
    try:
        thief.hello_twice(0.0)
    except DatagramError as error:
        assert error.reason is DropReason.UNKNOWN_ATTEMPT
    assert caller.hello(0.0) == answer


@pytest.mark.slow
def test_cookies_are_rate_limited() -> None:
    side, answered = responder(), 0
    for name in range(2 * int(RETRIES_PER_SECOND)):
        try:
            answered += Caller(side, name % 7).hello(0.0).kind is Kind.RETRY
        except DatagramError as error:
            assert error.reason is DropReason.RATE
    assert answered == RETRIES_PER_SECOND


@pytest.mark.slow
def test_an_attempt_expires_after_its_life_and_no_room_at_the_end_is_a_refusal() -> None:
    side = Responder(CODE, seeded("responder"), refuse=lambda *_: None, accept=lambda *_: None)
    caller = Caller(side, 1)
    answer = caller.hello_twice(0.0)
    side.expire(ATTEMPT_LIFE_S - 0.1)
    assert caller.confirm(answer, 1.0)[0].fields[1:] == (Refusal.FULL, 0)
    side.expire(ATTEMPT_LIFE_S)
    assert not side.attempts


def test_the_number_of_a_refusal_is_rounded_up_to_at_most_a_byte() -> None:
    assert [read(_refused(bytes(8), Refusal.LOCKED, n)).fields[2] for n in (0.1, 254.5, 999.0)] == [1, 255, 255]
