"""One attempt of a sender: what it sends when, and what it accepts as an answer."""

from random import Random

import pytest

from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.handshake import PROOF_BYTES, Refusal, SessionSecrets, proof, receiver_secrets
from conf.protocol.session.initiator import CONFIRM_TIMEOUT_S, HandshakeDone, HandshakeRefused, Initiator
from conf.protocol.session.packet import HandshakePacket, Kind, handshake_datagram, parse_datagram
from tests.support.simulated_sessions import CODE, seeded, state

COOKIE = b"cookie!!"


def read(data: bytes | None) -> HandshakePacket:
    assert data is not None
    packet = parse_datagram(data)
    assert isinstance(packet, HandshakePacket)
    return packet


def packet(kind: Kind, *fields: bytes | int) -> HandshakePacket:
    return read(handshake_datagram(kind, *fields))


class Attempt:
    """An initiator and the answers a receiver would give it."""

    def __init__(self) -> None:
        self.initiator = Initiator(CODE, seeded("initiator"), 0.0)
        self.attempt, self.cookie, self.share = read(self.initiator.datagram(0.0)).fields

    def answer(self) -> SessionSecrets:
        secrets, own = receiver_secrets(CODE, self.attempt, self.share, seeded("receiver"))
        self.initiator.receive(packet(Kind.ANSWER, self.attempt, own), 0.1)
        return secrets

    def refusal_of(self, answer: HandshakePacket) -> DropReason:
        before = state(self.initiator)
        with pytest.raises(DatagramError) as caught:
            self.initiator.receive(answer, 1.0)
        assert state(self.initiator) == before
        return caught.value.reason


def test_hello_is_repeated_four_times_soon_and_then_at_growing_intervals() -> None:
    initiator = Initiator(CODE, seeded("initiator"), 0.0)
    times = [t / 100 for t in range(2000) if initiator.datagram(t / 100) is not None]
    assert times == pytest.approx([0.0, 0.3, 0.6, 0.9, 1.2, 1.8, 3.0, 5.4, 9.4, 13.4, 17.4], abs=0.05)


def test_a_path_on_which_a_third_is_lost_connects_nearly_all_within_four_seconds() -> None:
    """Of each step (hello, hello with a cookie, confirm) a datagram and its answer must arrive."""
    initiator, random = Initiator(CODE, seeded("initiator"), 0.0), Random(1)
    times = [t / 100 for t in range(6000) if initiator.datagram(t / 100) is not None]
    calls = [sum(next(t for t in times if random.random() >= 1 / 3) for _ in range(3)) for _ in range(2000)]
    assert sum(duration > 4.0 for duration in calls) < 10


def test_only_the_first_cookie_is_answered_at_once() -> None:
    attempt = Attempt()
    assert attempt.cookie == bytes(8)
    attempt.initiator.receive(packet(Kind.RETRY, attempt.attempt, COOKIE), 0.1)
    assert read(attempt.initiator.datagram(0.1)).fields == (attempt.attempt, COOKIE, attempt.share)
    attempt.initiator.receive(packet(Kind.RETRY, attempt.attempt, b"another!"), 0.2)
    assert attempt.initiator.datagram(0.2) is None
    assert read(attempt.initiator.datagram(0.6)).fields == (attempt.attempt, b"another!", attempt.share)
    assert attempt.refusal_of(packet(Kind.RETRY, attempt.attempt, b"another!")) is DropReason.REPLAYED


def test_a_complete_handshake() -> None:
    attempt = Attempt()
    assert attempt.initiator.expires == float("inf")
    secrets = attempt.answer()
    for now in (0.1, 0.5):
        assert read(attempt.initiator.datagram(now)).fields == (attempt.attempt, 0, proof(secrets.sender_proof, 0))
        assert attempt.initiator.datagram(now + 0.2) is None
    done = packet(Kind.DONE, attempt.attempt, 9, proof(secrets.receiver_proof, 9))
    assert attempt.initiator.receive(done, 1.0) == HandshakeDone(9, secrets)
    assert attempt.initiator.expires == 0.1 + CONFIRM_TIMEOUT_S


def test_anything_but_an_answer_changes_nothing() -> None:
    attempt = Attempt()
    done = packet(Kind.DONE, attempt.attempt, 9, bytes(PROOF_BYTES))
    assert attempt.refusal_of(done) is DropReason.SEAL
    assert attempt.refusal_of(packet(Kind.HELLO, attempt.attempt, COOKIE, bytes(32))) is DropReason.DIRECTION
    assert attempt.refusal_of(packet(Kind.RETRY, b"somebody", COOKIE)) is DropReason.UNKNOWN_ATTEMPT
    assert attempt.refusal_of(packet(Kind.ANSWER, attempt.attempt, bytes(32))) is DropReason.SHARE
    assert attempt.refusal_of(packet(Kind.REFUSED, attempt.attempt, 200, 0)) is DropReason.SYNTAX
    secrets = attempt.answer()
    assert attempt.refusal_of(done) is DropReason.SEAL
    assert attempt.refusal_of(packet(Kind.RETRY, attempt.attempt, COOKIE)) is DropReason.REPLAYED
    assert attempt.refusal_of(packet(Kind.ANSWER, attempt.attempt, bytes(32))) is DropReason.REPLAYED
    too_high = packet(Kind.DONE, attempt.attempt, 128, proof(secrets.receiver_proof, 128))
    assert attempt.refusal_of(too_high) is DropReason.SYNTAX


def test_a_refusal_is_returned() -> None:
    attempt = Attempt()
    refused = packet(Kind.REFUSED, attempt.attempt, Refusal.LOCKED, 42)
    assert attempt.initiator.receive(refused, 1.0) == HandshakeRefused(Refusal.LOCKED, 42)
