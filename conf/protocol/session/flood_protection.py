"""What bounds strangers: cookies before work, a limit on wrong codes."""

import hashlib
import hmac
from collections import deque
from collections.abc import Callable

COOKIE_BYTES = 8
COOKIE_SLOT_S = 30.0
MAX_WRONG_CODES = 5
WRONG_CODES_PERIOD_S = 60.0

# What recvfrom gives: (host, port) for IPv4, (host, port, flow, scope) for IPv6.
Address = tuple[str, int] | tuple[str, int, int, int]


class CookieFactory:
    """Cookies prove that a sender receives at the address it names, and cost no memory.

    A cookie is a keyed BLAKE2s of the address, what is bound to it and the time slot; it lives 30 to 60 s.
    """

    def __init__(self, random: Callable[[int], bytes]) -> None:
        self._secret = random(32)

    def make(self, binding: bytes, address: Address, now: float) -> bytes:
        """Return the cookie for `address`, worthless for any other address or other `bound` bytes."""
        return self._bake(binding, address, int(now // COOKIE_SLOT_S))

    def check(self, cookie: bytes, binding: bytes, address: Address, now: float) -> bool:
        """Return whether the cookie was baked for just this in this time slot or the one before."""
        slot = int(now // COOKIE_SLOT_S)
        return any(hmac.compare_digest(cookie, self._bake(binding, address, s)) for s in (slot, slot - 1))

    def _bake(self, binding: bytes, address: Address, slot: int) -> bytes:
        text = f"{slot} {address[0]} {address[1]} ".encode()
        return hashlib.blake2s(text + binding, key=self._secret, digest_size=COOKIE_BYTES).digest()


class AttemptLimit:
    """At most five wrong codes in any minute, over all senders together."""

    def __init__(self) -> None:
        self._times: deque[float] = deque(maxlen=MAX_WRONG_CODES)

    def record(self, now: float) -> None:
        """Note a wrong code."""
        self._times.append(now)

    def tries_left(self, now: float) -> int:
        """Return how many wrong codes would still be answered now."""
        return MAX_WRONG_CODES - sum(now - time < WRONG_CODES_PERIOD_S for time in self._times)

    def wait(self, now: float) -> float:
        """Return the seconds until a code may be tried again, 0 if it may be now."""
        return 0.0 if self.tries_left(now) else max(0.0, self._times[0] + WRONG_CODES_PERIOD_S - now)
