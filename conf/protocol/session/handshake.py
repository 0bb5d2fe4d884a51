"""What both sides of the handshake share: the flow, the SPAKE2 shares, the keys and proofs that come of them.

    sender (initiator)                                     receiver (responder)
    HELLO(attempt, no cookie, share A)      57 B  ->
                                                  <-  25 B  RETRY(attempt, cookie)           nothing kept, no curve work
    HELLO(attempt, cookie, share A)         57 B  ->
                                                  <-  49 B  ANSWER(attempt, share B)
    CONFIRM(attempt, proof)                 34 B  ->
                                                  <-  34 B  DONE(attempt, session, proof)     or 19 B REFUSED

Strategy. The sender proves first: until then the receiver has told nothing by which a code could be tested, so exactly
the wrong proofs are counted as wrong codes. `attempt` (8 random bytes) names a handshake: who has not seen its
datagrams cannot answer in it. Only the sender repeats itself; the receiver answers a repetition as the first time.
"""

import copy
import hashlib
import hmac
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.kdf.hkdf import HKDF
from spake2 import SPAKE2_A, SPAKE2_B, SPAKEError
from spake2.ed25519_basic import NotOnCurve

from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.packet import VERSION
from conf.protocol.session.seal import SECRET_BYTES

SENDER_ID, RECEIVER_ID = b"conf sender", b"conf receiver"
ATTEMPT_BYTES = 8
PROOF_BYTES = 16
NO_COOKIE = bytes(8)

RandomBytes = Callable[[int], bytes]


class Refusal(IntEnum):
    """Why a receiver refuses a handshake, and what the number beside it means."""

    WRONG_CODE = 0  # tries left
    LOCKED = 1  # too many wrong codes lately: seconds to wait
    FULL = 2  # all sessions taken: 0
    BUSY = 3  # too many handshakes under way: seconds to wait


@dataclass(frozen=True)
class SessionSecrets:
    """What a handshake yields, 32 B each: the two chains of keys, and the keys of the two proofs."""

    from_sender: bytes
    from_receiver: bytes
    sender_proof: bytes
    receiver_proof: bytes


def sender_share(code: str, random: RandomBytes) -> tuple[SPAKE2_A, bytes]:
    """Return the sender's half of SPAKE2 and its share (32 B)."""
    half = SPAKE2_A(code.encode(), idA=SENDER_ID, idB=RECEIVER_ID, entropy_f=random)
    return half, half.start()[1:]


def sender_secrets(spake: SPAKE2_A, attempt: bytes, shares: tuple[bytes, bytes]) -> SessionSecrets:
    """Return the secrets. shares : the sender's and the receiver's. Raises DatagramError if the latter is no share."""
    return _secrets(_finish(spake, b"B" + shares[1]), attempt, shares)


def receiver_secrets(code: str, attempt: bytes, key_share: bytes, random: RandomBytes) -> tuple[SessionSecrets, bytes]:
    """Return the secrets and the receiver's share. Raises DatagramError if `share`, the sender's, is no share."""
    half = SPAKE2_B(code.encode(), idA=SENDER_ID, idB=RECEIVER_ID, entropy_f=random)
    own = half.start()[1:]
    return _secrets(_finish(half, b"A" + key_share), attempt, (key_share, own)), own


def proof(key: bytes, session: int) -> bytes:
    """Return the proof (16 B) that its maker knows the key; the receiver's also covers the session it names."""
    return hmac.digest(key, bytes((VERSION, session)), "sha256")[:PROOF_BYTES]


def _finish(spake: SPAKE2_A | SPAKE2_B, message: bytes) -> bytes:
    try:
        key: bytes = copy.copy(spake).finish(message)  # a half finishes once, and a forged share must not use it up
    except (ValueError, NotOnCurve, SPAKEError):
        raise DatagramError(DropReason.SHARE) from None
    return key


def _secrets(key: bytes, attempt: bytes, shares: tuple[bytes, bytes]) -> SessionSecrets:
    transcript = hashlib.sha256(b"".join((bytes((VERSION,)), SENDER_ID, RECEIVER_ID, attempt, *shares))).digest()
    material = HKDF(SHA256(), 4 * SECRET_BYTES, salt=transcript, info=b"conf session").derive(key)
    return SessionSecrets(*(material[i : i + SECRET_BYTES] for i in range(0, len(material), SECRET_BYTES)))
