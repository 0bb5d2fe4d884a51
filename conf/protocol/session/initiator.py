"""The sender's side of one handshake: says hello until it is answered, proves the code, checks the receiver's proof."""

import hmac
from dataclasses import dataclass
from typing import Any

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

FIRST_REPEAT_S = 0.4
MAX_REPEAT_S = 4.0
# One proof is one guess for a false receiver: an attempt that gets no DONE is given up for a new one only after this
# long, at most three a minute. The receiver keeps its side longer than that (responder.py).
CONFIRM_TIMEOUT_S = 20.0


@dataclass(frozen=True)
class HandshakeDone:
    """The handshake is over: the session's number and secrets."""

    session: int
    secrets: SessionSecrets


@dataclass(frozen=True)
class HandshakeRefused:
    """The receiver refuses. number : see Refusal."""

    refusal: Refusal
    number: int


class Initiator:
    """One attempt at a handshake. `secrets` is None until the receiver has answered the hello."""

    def __init__(self, code: str, random: RandomBytes, start: float) -> None:
        self.secrets: SessionSecrets | None = None
        self.due = start
        self.expires = float("inf")
        self._repeat_s = FIRST_REPEAT_S
        self._attempt = random(ATTEMPT_BYTES)
        self._spake, self._share = sender_share(code, random)
        self._cookie = NO_COOKIE

    def datagram(self, now: float) -> bytes | None:
        """Return what is to be sent now, if anything, and wait twice as long before the next repetition."""
        if now < self.due:
            return None
        self.due = now + self._repeat_s
        self._repeat_s = min(2 * self._repeat_s, MAX_REPEAT_S)
        if self.secrets is None:
            return handshake_datagram(Kind.HELLO, self._attempt, self._cookie, self._share)
        return handshake_datagram(Kind.CONFIRM, self._attempt, 0, proof(self.secrets.sender_proof, 0))

    def receive(self, packet: HandshakePacket, now: float) -> HandshakeDone | HandshakeRefused | None:
        """Take the receiver's answer. Raises DatagramError if it is not one to this attempt, at this moment."""
        handler = _HANDLERS.get(packet.kind)
        if handler is None:
            raise DatagramError(DropReason.DIRECTION)
        attempt, *fields = packet.fields
        if attempt != self._attempt:
            raise DatagramError(DropReason.UNKNOWN_ATTEMPT)
        return handler(self, fields, now)

    def _receive_retry(self, fields: list[Any], now: float) -> None:
        (cookie,) = fields
        if self.secrets is not None or cookie == self._cookie:
            raise DatagramError(DropReason.REPLAYED)
        if self._cookie == NO_COOKIE:  # answer at once, but once: two cookies in turn must not make a storm
            self._send_soon(now)
        self._cookie = cookie

    def _receive_answer(self, fields: list[Any], now: float) -> None:
        (share,) = fields
        if self.secrets is not None:
            raise DatagramError(DropReason.REPLAYED)
        self.secrets = sender_secrets(self._spake, self._attempt, (self._share, share))
        self.expires = now + CONFIRM_TIMEOUT_S
        self._send_soon(now)

    def _receive_done(self, fields: list[Any], _now: float) -> HandshakeDone:
        session, mac = fields
        if self.secrets is None or not hmac.compare_digest(mac, proof(self.secrets.receiver_proof, session)):
            raise DatagramError(DropReason.SEAL)
        if session > MAX_SESSION:
            raise DatagramError(DropReason.SYNTAX)
        return HandshakeDone(session, self.secrets)

    def _receive_refused(self, fields: list[Any], _now: float) -> HandshakeRefused:
        refusal, number = fields
        try:
            return HandshakeRefused(Refusal(refusal), number)
        except ValueError:
            raise DatagramError(DropReason.SYNTAX) from None

    def _send_soon(self, now: float) -> None:
        self.due = now
        self._repeat_s = FIRST_REPEAT_S


_HANDLERS = {
    Kind.RETRY: Initiator._receive_retry,
    Kind.ANSWER: Initiator._receive_answer,
    Kind.DONE: Initiator._receive_done,
    Kind.REFUSED: Initiator._receive_refused,
}
