"""Probes of a peer's new address: a session moves there only after the peer has answered from the inside of the seal.

Strategy. A valid datagram from another address may be a copy that somebody has sent ahead of the original. So it causes
no more than a probe to that address: a small sealed body with a random token. Only the peer can open it, and it answers
with the same token. Until the answer has arrived, all else goes to the old address. A datagram causes at most one
probe, which is not larger than most datagrams, so nobody can multiply traffic. Source: RFC 9000, 8.2 and 9.3.
"""

import hmac
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

from conf.protocol.address import Address
from conf.protocol.rate_control.rate_limit import TokenBucket

PATH_PROBE, PATH_ANSWER = 0x0C, 0x0D  # kinds of bodies, see WIRE.md
TOKEN_BYTES = 8
PROBE_INTERVAL_S = 0.1  # to one address
MAX_CANDIDATES = 12  # addresses that are probed at a time: the announced ones, and some that were not
CANDIDATE_LIFE_S = 5.0
PER_SECOND = 20.0  # probes, and answers


@dataclass
class _Candidate:
    """An address under validation. began : with the first probe"""

    token: bytes
    began: float
    probed_at: float


class PathValidation:
    """Validate the addresses from which a session's datagrams come."""

    def __init__(self, random: Callable[[int], bytes]) -> None:
        """random : n -> n random bytes"""
        self._random = random
        self._candidates: OrderedDict[Address, _Candidate] = OrderedDict()
        self._probes = TokenBucket(PER_SECOND, PER_SECOND)
        self._answers = TokenBucket(PER_SECOND, PER_SECOND)

    def probe(self, address: Address, now: float) -> bytes | None:
        """Return the body to send to an address from which a valid datagram has come, None if it was just probed."""
        known = self._candidates.get(address)
        if known and now < known.probed_at + PROBE_INTERVAL_S:
            return None
        if not self._probes.consume(1, now):
            return None
        if known is None or now >= known.began + CANDIDATE_LIFE_S:
            known = _Candidate(self._random(TOKEN_BYTES), now, now)
        known.probed_at = now
        self._candidates[address] = known
        self._candidates.move_to_end(address)
        if len(self._candidates) > MAX_CANDIDATES:
            self._candidates.popitem(last=False)
        return bytes((PATH_PROBE,)) + known.token

    def answer_to(self, body: bytes, now: float) -> bytes | None:
        """Return the answer if a body is a probe, to be sent where that came from."""
        if body[:1] != bytes((PATH_PROBE,)) or len(body) != 1 + TOKEN_BYTES or not self._answers.consume(1, now):
            return None
        return bytes((PATH_ANSWER,)) + body[1:]

    def validated_by(self, body: bytes, now: float) -> Address | None:
        """Return the address that a body validates if it is the answer to a probe; all candidates are dropped then."""
        if body[:1] != bytes((PATH_ANSWER,)):
            return None
        for address, candidate in self._candidates.items():
            if hmac.compare_digest(body[1:], candidate.token) and now < candidate.began + CANDIDATE_LIFE_S:
                self._candidates.clear()
                return address
        return None
