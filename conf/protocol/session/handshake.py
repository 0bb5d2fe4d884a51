"""What both sides of the handshake have in common: its flow, the SPAKE2 key shares, the session's keys and proofs.

    sender (initiator)                                     receiver (responder)
    HELLO(attempt, no cookie, share A)      57 B  ->
                                                  <-  25 B  RETRY(attempt, cookie)           no state, no curve work
    HELLO(attempt, cookie, share A)         57 B  ->
                                                  <-  49 B  ANSWER(attempt, share B)
    CONFIRM(attempt, proof)                 34 B  ->
                                                  <-  34 B  DONE(attempt, session, proof)     or 19 B REFUSED

Strategy. The sender proves first. Until then the receiver has revealed nothing by which a code could be tested, so that
exactly the wrong proofs count as wrong codes. `attempt` (8 random bytes) identifies a handshake: only who has seen its
datagrams can answer in it. Only the sender repeats datagrams; the receiver answers a repetition identically.
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
    LOCKED = 1  # too many wrong codes in the last minute: seconds to wait
    FULL = 2  # no free session: 0
    BUSY = 3  # too many handshakes in progress: seconds to wait
    IN_CALL = 4  # in a call with somebody else: seconds to wait


@dataclass(frozen=True)
class SessionSecrets:
    """The result of a handshake, 32 B each: the secrets of both key chains, and the keys of both proofs."""

    from_sender: bytes
    from_receiver: bytes
    sender_proof: bytes
    receiver_proof: bytes


def sender_share(code: str, random: RandomBytes) -> tuple[SPAKE2_A, bytes]:
    """Return the sender's SPAKE2 state and its key share (32 B)."""
    spake = SPAKE2_A(code.encode(), idA=SENDER_ID, idB=RECEIVER_ID, entropy_f=random)
    return spake, spake.start()[1:]


def sender_secrets(spake: SPAKE2_A, attempt: bytes, shares: tuple[bytes, bytes]) -> SessionSecrets:
    """Return the secrets. shares : the sender's and the receiver's. Raises DatagramError if the latter is invalid."""
    return _secrets(_finish(spake, b"B" + shares[1]), attempt, shares)


def receiver_secrets(code: str, attempt: bytes, key_share: bytes, random: RandomBytes) -> tuple[SessionSecrets, bytes]:
    """Return the secrets and the receiver's key share. Raises DatagramError if the sender's `key_share` is invalid."""
    spake = SPAKE2_B(code.encode(), idA=SENDER_ID, idB=RECEIVER_ID, entropy_f=random)
    own = spake.start()[1:]
    return _secrets(_finish(spake, b"A" + key_share), attempt, (key_share, own)), own


def proof(key: bytes, session: int) -> bytes:
    """Return the proof (16 B) that its maker has the key; the receiver's also covers the session number."""
    return hmac.digest(key, bytes((VERSION, session)), "sha256")[:PROOF_BYTES]


def _finish(spake: SPAKE2_A | SPAKE2_B, message: bytes) -> bytes:
    try:
        # A copy, as the state can finish only once and a forged share must not use it up.
        key: bytes = copy.copy(spake).finish(message)
    except (ValueError, NotOnCurve, SPAKEError):
        raise DatagramError(DropReason.SHARE) from None
    return key


def _secrets(key: bytes, attempt: bytes, shares: tuple[bytes, bytes]) -> SessionSecrets:
    transcript = hashlib.sha256(b"".join((bytes((VERSION,)), SENDER_ID, RECEIVER_ID, attempt, *shares))).digest()
    material = HKDF(SHA256(), 4 * SECRET_BYTES, salt=transcript, info=b"conf session").derive(key)
    return SessionSecrets(*(material[i : i + SECRET_BYTES] for i in range(0, len(material), SECRET_BYTES)))
