"""The sender's side of one handshake: repeat the hello, prove the code, check the receiver's proof."""

import hmac
from dataclasses import dataclass

from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.handshake import (
    ATTEMPT_BYTES,
    NO_COOKIE,
    RandomBytes,
    Refusal,
    SessionSecrets,
    proof,
    sender_secrets,
    sender_share,
)
from conf.protocol.session.packet import MAX_SESSION, HandshakePacket, Kind, handshake_datagram

FIRST_REPEAT_S = 0.3
EQUAL_REPEATS = 4  # of each step, before the time between them doubles: a path that loses a third is only slow
MAX_REPEAT_S = 4.0
# Each proof lets a false receiver test one guess. An attempt without DONE is replaced by a new one only after this
# time, at most three a minute. The receiver keeps its state longer than that (responder.py).
CONFIRM_TIMEOUT_S = 20.0


@dataclass(frozen=True)
class HandshakeDone:
    """The handshake succeeded: the session's number and secrets."""

    session: int
    secrets: SessionSecrets


@dataclass(frozen=True)
class HandshakeRefused:
    """The receiver refused. number : see Refusal"""

    refusal: Refusal
    number: int


class Initiator:
    """One attempt at a handshake.

    attempt : random bytes that identify it
    secrets : None until the receiver has answered the hello
    expires : when to replace the attempt by a new one
    """

    def __init__(self, code: str, random: RandomBytes, start: float) -> None:
        self.secrets: SessionSecrets | None = None
        self.expires = float("inf")
        self._due = start
        self._repeat_s = FIRST_REPEAT_S
        self._repeats = 0  # of the present step
        self.attempt = random(ATTEMPT_BYTES)
        self._spake, self._share = sender_share(code, random)
        self._cookie = NO_COOKIE

    def datagram(self, now: float) -> bytes | None:
        """Return the datagram that is due, if any, and set the time of its next repetition."""
        if now < self._due:
            return None
        self._due = now + self._repeat_s
        self._repeats += 1
        if self._repeats >= EQUAL_REPEATS:
            self._repeat_s = min(2 * self._repeat_s, MAX_REPEAT_S)
        if self.secrets is None:
            return handshake_datagram(Kind.HELLO, self.attempt, self._cookie, self._share)
        return handshake_datagram(Kind.CONFIRM, self.attempt, 0, proof(self.secrets.sender_proof, 0))

    def receive(self, packet: HandshakePacket, now: float) -> HandshakeDone | HandshakeRefused | None:
        """Apply the receiver's answer. Raises DatagramError if it is not one to the last datagram of this attempt."""
        if packet.kind not in {Kind.RETRY, Kind.ANSWER, Kind.DONE, Kind.REFUSED}:
            raise DatagramError(DropReason.DIRECTION)
        attempt, *fields = packet.fields
        if attempt != self.attempt:
            raise DatagramError(DropReason.UNKNOWN_ATTEMPT)
        if packet.kind is Kind.DONE:
            return self._receive_done(*fields)
        if packet.kind is Kind.REFUSED:
            return self._receive_refused(*fields)
        if packet.kind is Kind.RETRY:
            self._receive_retry(fields[0], now)
        else:
            self._receive_answer(fields[0], now)
        return None

    def _receive_retry(self, cookie: bytes, now: float) -> None:
        if self.secrets is not None or cookie == self._cookie:
            raise DatagramError(DropReason.REPLAYED)
        if self._cookie == NO_COOKIE:  # repeat at once, but only once: two alternating cookies must cause no storm
            self._send_at_once(now)
        self._cookie = cookie

    def _receive_answer(self, share: bytes, now: float) -> None:
        if self.secrets is not None:
            raise DatagramError(DropReason.REPLAYED)
        self.secrets = sender_secrets(self._spake, self.attempt, (self._share, share))
        self.expires = now + CONFIRM_TIMEOUT_S
        self._send_at_once(now)

    def _receive_done(self, session: int, mac: bytes) -> HandshakeDone:
        if self.secrets is None or not hmac.compare_digest(mac, proof(self.secrets.receiver_proof, session)):
            raise DatagramError(DropReason.SEAL)
        if session > MAX_SESSION:
            raise DatagramError(DropReason.SYNTAX)
        return HandshakeDone(session, self.secrets)

    @staticmethod
    def _receive_refused(refusal: int, number: int) -> HandshakeRefused:
        try:
            return HandshakeRefused(Refusal(refusal), number)
        except ValueError:
            raise DatagramError(DropReason.SYNTAX) from None

    def _send_at_once(self, now: float) -> None:
        self._due = now
        self._repeat_s = FIRST_REPEAT_S
        self._repeats = 0
