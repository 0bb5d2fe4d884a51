"""Authenticated encryption of bodies: AES-128-CCM with 8-byte tags, one chain of keys for each direction.

Strategy. A counter identifies a datagram of a session and is never used twice. It also selects the key: the epoch is
counter // EPOCH_LENGTH. Each epoch's key is derived from the one before by a one-way step, so that a key change needs
no message and an old key cannot be computed from a newer one. An OpeningKey holds the keys of three epochs: the
previous, the current and the next. It advances only by an authentic datagram, so that junk never causes a key
derivation.

nonce (13 B) = the epoch's salt (5 B) and the counter (8 B, big-endian); associated data = the header as sent.
"""

from dataclasses import dataclass

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESCCM
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.kdf.hkdf import HKDFExpand

from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.packet import MAX_COUNTER, TAG_BYTES, DataPacket, data_header, restore_counter
from conf.protocol.session.replay_window import ReplayWindow

EPOCH_LENGTH = 1 << 20
NEXT_FEW = 4  # datagrams whose size is asked for before they are sealed
SECRET_BYTES, KEY_BYTES, SALT_BYTES = 32, 16, 5


class CounterExhausted(Exception):  # noqa: N818 - the end of a session, no error
    """A session has used its last counter: a new handshake is needed."""


@dataclass(frozen=True)
class EpochKey:
    """The cipher of one epoch of one direction."""

    cipher: AESCCM
    salt: bytes

    def nonce(self, counter: int) -> bytes:
        """Return the 13-byte nonce of a datagram."""
        return self.salt + counter.to_bytes(8)


class KeyChain:
    """The keys of one direction, one for each epoch. secret : 32 B, replaced when the next key is derived"""

    def __init__(self, secret: bytes) -> None:
        self._secret = secret
        self.next_epoch = 0

    def next_key(self) -> EpochKey:
        """Return the key of `next_epoch` and advance to the following epoch."""
        size = KEY_BYTES + SALT_BYTES + SECRET_BYTES
        material = HKDFExpand(SHA256(), size, b"conf epoch").derive(self._secret)
        self._secret = material[-SECRET_BYTES:]
        self.next_epoch += 1
        return EpochKey(AESCCM(material[:KEY_BYTES], tag_length=TAG_BYTES), material[KEY_BYTES:-SECRET_BYTES])


class SealingKey:
    """Seal bodies with rising counters: an AEAD key bound to its nonces, as in the library ring.

    counter : of the next datagram
    acknowledged : the newest counter the peer is known to have received, -1 if none; shortens the counters on the wire
    """

    def __init__(self, session: int, secret: bytes, *, epoch_length: int = EPOCH_LENGTH) -> None:
        self.session = session
        self.counter = 0
        self.acknowledged = -1
        self._epoch_length = epoch_length
        self._chain = KeyChain(secret)
        self._key = self._chain.next_key()

    def seal(self, body: bytes) -> bytes:
        """Return the datagram that carries `body`.

        Raises ValueError if it is too long, CounterExhausted after 2^32 datagrams.
        """
        counter = self.counter
        if counter > MAX_COUNTER:
            raise CounterExhausted
        header = data_header(self.session, counter, self.acknowledged, len(body))
        if counter // self._epoch_length >= self._chain.next_epoch:
            self._key = self._chain.next_key()
        self.counter = counter + 1
        return header + self._key.cipher.encrypt(self._key.nonce(counter), body, header)

    def sealed_bytes(self, body_bytes: int) -> int:
        """Return the size of a datagram with a body of `body_bytes`, if it is among the next few."""
        header = data_header(self.session, min(self.counter + NEXT_FEW, MAX_COUNTER), self.acknowledged, body_bytes)
        return len(header) + body_bytes + TAG_BYTES

    def acknowledge(self, counter: int) -> None:
        """Record that the peer has received `counter`; one that was never sent is ignored."""
        if self.acknowledged < counter < self.counter:
            self.acknowledged = counter


class OpeningKey:
    """Open each sealed datagram once: the peer's half of a SealingKey, with the window against replays."""

    def __init__(self, secret: bytes, *, epoch_length: int = EPOCH_LENGTH) -> None:
        self.window = ReplayWindow()
        self._epoch_length = epoch_length
        self._chain = KeyChain(secret)
        self._keys = {epoch: self._chain.next_key() for epoch in range(2)}

    def open(self, packet: DataPacket) -> tuple[int, bytes]:
        """Return the full counter and the body.

        Raises DatagramError, and changes nothing, if the datagram was received before or is not authentic.
        """
        counter = restore_counter(packet.counter, self.window.highest)
        self.window.check(counter)
        epoch = counter // self._epoch_length
        key = self._keys.get(epoch)
        if key is None or counter > MAX_COUNTER:
            raise DatagramError(DropReason.COUNTER)
        try:
            body = key.cipher.decrypt(key.nonce(counter), packet.sealed, packet.header)
        except InvalidTag:
            raise DatagramError(DropReason.SEAL) from None
        self.window.accept(counter)
        if epoch + 1 == self._chain.next_epoch:
            self._keys[epoch + 1] = self._chain.next_key()
            self._keys.pop(epoch - 2, None)
        return counter, body
