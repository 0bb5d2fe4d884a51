"""One attempt of a sender: what it sends when, and what it takes for an answer."""

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


class Bench:
    """An initiator and the answers a receiver would give it."""

    def __init__(self) -> None:
        self.initiator = Initiator(CODE, seeded("initiator"), 0.0)
        self.attempt, self.cookie, self.share = read(self.initiator.datagram(0.0)).fields

    def answer(self) -> SessionSecrets:
        secrets, own = receiver_secrets(CODE, self.attempt, self.share, seeded("bench"))
        self.initiator.receive(packet(Kind.ANSWER, self.attempt, own), 1.0)
        return secrets

    def refusal_of(self, answer: HandshakePacket) -> DropReason:
        before = state(self.initiator)
        with pytest.raises(DatagramError) as caught:
            self.initiator.receive(answer, 1.0)
        assert state(self.initiator) == before
        return caught.value.reason


def test_hello_is_repeated_ever_more_slowly() -> None:
    initiator = Initiator(CODE, seeded("initiator"), 0.0)
    times = [t / 100 for t in range(2000) if initiator.datagram(t / 100) is not None]
    assert times == pytest.approx([0.0, 0.4, 1.2, 2.8, 6.0, 10.0, 14.0, 18.0], abs=0.05)


def test_a_cookie_is_answered_at_once_but_only_the_first() -> None:
    bench = Bench()
    assert bench.cookie == bytes(8)
    bench.initiator.receive(packet(Kind.RETRY, bench.attempt, COOKIE), 0.1)
    assert read(bench.initiator.datagram(0.1)).fields == (bench.attempt, COOKIE, bench.share)
    bench.initiator.receive(packet(Kind.RETRY, bench.attempt, b"another!"), 0.2)
    assert bench.initiator.datagram(0.2) is None
    assert read(bench.initiator.datagram(0.6)).fields == (bench.attempt, b"another!", bench.share)
    assert bench.refusal_of(packet(Kind.RETRY, bench.attempt, b"another!")) is DropReason.REPLAYED


def test_the_whole_way() -> None:
    bench = Bench()
    secrets = bench.answer()
    assert read(bench.initiator.datagram(1.0)).fields == (bench.attempt, 0, proof(secrets.sender_proof, 0))
    done = packet(Kind.DONE, bench.attempt, 9, proof(secrets.receiver_proof, 9))
    assert bench.initiator.receive(done, 1.0) == HandshakeDone(9, secrets)
    assert bench.initiator.expires == 1.0 + CONFIRM_TIMEOUT_S


def test_what_is_not_an_answer_changes_nothing() -> None:
    bench = Bench()
    done = packet(Kind.DONE, bench.attempt, 9, bytes(PROOF_BYTES))
    assert bench.refusal_of(done) is DropReason.SEAL
    assert bench.refusal_of(packet(Kind.HELLO, bench.attempt, COOKIE, bytes(32))) is DropReason.DIRECTION
    assert bench.refusal_of(packet(Kind.RETRY, b"somebody", COOKIE)) is DropReason.UNKNOWN_ATTEMPT
    assert bench.refusal_of(packet(Kind.ANSWER, bench.attempt, bytes(32))) is DropReason.SHARE
    assert bench.refusal_of(packet(Kind.REFUSED, bench.attempt, 200, 0)) is DropReason.SYNTAX
    secrets = bench.answer()
    assert bench.refusal_of(done) is DropReason.SEAL
    assert bench.refusal_of(packet(Kind.RETRY, bench.attempt, COOKIE)) is DropReason.REPLAYED
    assert bench.refusal_of(packet(Kind.ANSWER, bench.attempt, bytes(32))) is DropReason.REPLAYED
    too_high = packet(Kind.DONE, bench.attempt, 128, proof(secrets.receiver_proof, 128))
    assert bench.refusal_of(too_high) is DropReason.SYNTAX


def test_a_refusal_is_told() -> None:
    bench = Bench()
    refused = packet(Kind.REFUSED, bench.attempt, Refusal.LOCKED, 42)
    assert bench.initiator.receive(refused, 1.0) == HandshakeRefused(Refusal.LOCKED, 42)
