"""The receiver's side of all handshakes, with bounded work for strangers.

Strategy. A hello without a valid cookie gets a cookie and leaves no state. With one it may cause the curve work (7 ms
of Python), of which a token bucket allows a few a second, and an entry in a table of limited size. Every answer is kept
with its attempt, so that a repeated datagram gets the same answer and is not counted again.
"""

import hmac
import math
from collections.abc import Callable
from dataclasses import dataclass

from conf.protocol.address import Address, host_of
from conf.protocol.rate_control.rate_limit import TokenBucket
from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.flood_protection import (
    RELAY_CODES_PERIOD_S,
    WRONG_CODES_PERIOD_S,
    AttemptLimit,
    CookieFactory,
)
from conf.protocol.session.handshake import RandomBytes, Refusal, SessionSecrets, proof, receiver_secrets
from conf.protocol.session.packet import Kind, handshake_datagram
from conf.protocol.session.pairing_code import nameplate_of

MAX_ATTEMPTS = 32
MAX_ATTEMPTS_PER_HOST = 8
ATTEMPT_LIFE_S = 30.0
# Cookies a second: a flood of hellos must not fill a slow link with answers. A hello with a cookie is not delayed.
RETRIES_PER_SECOND = 200.0
ANSWERS_PER_SECOND = 5.0
ANSWER_BURST = 10.0
BUSY_WAIT_S = 2

# (address, now) -> why no session would be accepted, and the refusal's number; None if one would
Refuse = Callable[[Address, float], tuple[Refusal, float] | None]


@dataclass
class Attempt:
    """A handshake in progress or, once it has an outcome (DONE or REFUSED), remembered for repetitions.

    name : the initiator's random bytes; begun : when its hello was answered
    """

    name: bytes
    begun: float
    address: Address
    share: bytes
    secrets: SessionSecrets
    answer: bytes
    outcome: bytes | None = None

    @property
    def expires(self) -> float:
        """When to forget it."""
        return self.begun + ATTEMPT_LIFE_S


# (attempt, address, now) -> the new session's number, or None if there is no room.
# Raises DatagramError if the attempt must not become a session now; its confirm then counts as not received.
Accept = Callable[[Attempt, Address, float], int | None]


class Responder:
    """Answer hellos and confirms.

    refuse : why a session would not be accepted from an address
    accept : called with an attempt whose proof was right
    """

    def __init__(self, code: str, random: RandomBytes, *, refuse: Refuse, accept: Accept) -> None:
        self.limit = AttemptLimit(RELAY_CODES_PERIOD_S if nameplate_of(code) else WRONG_CODES_PERIOD_S)
        self.attempts: dict[bytes, Attempt] = {}
        self._code = code
        self._random = random
        self.refuse = refuse
        self._accept = accept
        self._cookies = CookieFactory(random)
        self._retries = TokenBucket(RETRIES_PER_SECOND, RETRIES_PER_SECOND)
        self._answers = TokenBucket(ANSWERS_PER_SECOND, ANSWER_BURST)

    def expire(self, now: float) -> None:
        """Remove the attempts whose time is over."""
        self.attempts = {name: attempt for name, attempt in self.attempts.items() if attempt.expires > now}

    def hello(self, fields: tuple[bytes, bytes, bytes], address: Address, now: float) -> bytes:
        """Return the answer to a hello: RETRY, ANSWER or REFUSED. Raises DatagramError if it gets none."""
        name, cookie, share = fields
        known = self.attempts.get(name)
        if known is not None and (known.address, known.share) == (address, share):
            return known.answer
        if not self._cookies.check(cookie, name + share, address, now):
            if not self._retries.consume(1, now):
                raise DatagramError(DropReason.RATE)
            return handshake_datagram(Kind.RETRY, name, self._cookies.make(name + share, address, now))
        if known is not None:
            raise DatagramError(DropReason.UNKNOWN_ATTEMPT)
        return self._refusal(name, address, now) or self._begin(name, share, address, now)

    def confirm(self, fields: tuple[bytes, int, bytes], address: Address, now: float) -> tuple[bytes, int | None]:
        """Return the answer to a confirm, DONE or REFUSED, and the tries left if it has just revealed a wrong code.

        Raises DatagramError if it belongs to no attempt here.
        """
        name, _, mac = fields
        attempt = self.attempts.get(name)
        if attempt is None:
            raise DatagramError(DropReason.UNKNOWN_ATTEMPT)
        if attempt.outcome is not None:
            return attempt.outcome, None
        if wait := self.limit.wait(now):  # locked: the proof is not even checked
            return _refused(name, Refusal.LOCKED, wait), None
        if hmac.compare_digest(mac, proof(attempt.secrets.sender_proof, 0)):
            attempt.outcome = self._finish(attempt, address, now)
            return attempt.outcome, None
        self.limit.record(now)
        tries_left = self.limit.tries_left(now)
        attempt.outcome = _refused(name, Refusal.WRONG_CODE, tries_left)
        return attempt.outcome, tries_left

    def _refusal(self, name: bytes, address: Address, now: float) -> bytes | None:
        if wait := self.limit.wait(now):
            return _refused(name, Refusal.LOCKED, wait)
        if refusal := self.refuse(address, now):
            return _refused(name, *refusal)
        self.expire(now)
        hosts = [host_of(attempt.address) for attempt in self.attempts.values() if attempt.outcome is None]
        is_full = len(self.attempts) >= MAX_ATTEMPTS or hosts.count(host_of(address)) >= MAX_ATTEMPTS_PER_HOST
        if is_full or not self._answers.consume(1, now):
            return _refused(name, Refusal.BUSY, BUSY_WAIT_S)
        return None

    def _begin(self, name: bytes, share: bytes, address: Address, now: float) -> bytes:
        secrets, own_share = receiver_secrets(self._code, name, share, self._random)
        answer = handshake_datagram(Kind.ANSWER, name, own_share)
        self.attempts[name] = Attempt(name, now, address, share, secrets, answer)
        return answer

    def _finish(self, attempt: Attempt, address: Address, now: float) -> bytes:
        session = self._accept(attempt, address, now)
        if session is None:
            return _refused(attempt.name, *(self.refuse(address, now) or (Refusal.FULL, 0.0)))
        return handshake_datagram(Kind.DONE, attempt.name, session, proof(attempt.secrets.receiver_proof, session))


def _refused(name: bytes, refusal: Refusal, number: float) -> bytes:
    return handshake_datagram(Kind.REFUSED, name, refusal, min(255, math.ceil(number)))
