"""Limits on what strangers can cause: address cookies before any work, and a limit on wrong codes."""

import hashlib
import hmac
from collections import deque
from collections.abc import Callable

from conf.protocol.address import Address

COOKIE_BYTES = 8
COOKIE_SLOT_S = 30.0
MAX_WRONG_CODES = 5
WRONG_CODES_PERIOD_S = 60.0
RELAY_CODES_PERIOD_S = 300.0  # a code for a relay has a shorter secret


class CookieFactory:
    """Make and check cookies, which prove without stored state that a sender receives at the address it names.

    A cookie is a keyed BLAKE2s of the address, the bytes bound to it and the time slot. It is valid for 30 to 60 s.
    """

    def __init__(self, random: Callable[[int], bytes]) -> None:
        self._secret = random(32)

    def make(self, binding: bytes, address: Address, now: float) -> bytes:
        """Return the cookie for `address`, invalid for any other address or other `binding` bytes."""
        return self._digest(binding, address, int(now // COOKIE_SLOT_S))

    def check(self, cookie: bytes, binding: bytes, address: Address, now: float) -> bool:
        """Return whether the cookie was made for these bytes and this address in this time slot or the previous."""
        slot = int(now // COOKIE_SLOT_S)
        return any(hmac.compare_digest(cookie, self._digest(binding, address, s)) for s in (slot, slot - 1))

    def _digest(self, binding: bytes, address: Address, slot: int) -> bytes:
        text = f"{slot} {address[0]} {address[1]} ".encode()
        return hashlib.blake2s(text + binding, key=self._secret, digest_size=COOKIE_BYTES).digest()


class AttemptLimit:
    """Allow at most five wrong codes in any period, over all senders together, whatever addresses they have."""

    def __init__(self, period_s: float = WRONG_CODES_PERIOD_S) -> None:
        self._period_s = period_s
        self._times: deque[float] = deque(maxlen=MAX_WRONG_CODES)

    def record(self, now: float) -> None:
        """Count a wrong code."""
        self._times.append(now)

    def tries_left(self, now: float) -> int:
        """Return how many wrong codes would still be answered now."""
        return MAX_WRONG_CODES - sum(now - time < self._period_s for time in self._times)

    def wait(self, now: float) -> float:
        """Return the seconds until a code may be tried again, 0 if it may be tried now."""
        return 0.0 if self.tries_left(now) else max(0.0, self._times[0] + self._period_s - now)
