"""The golden datagrams have not changed, and an independent implementation of WIRE.md opens them."""

import hashlib
import hmac
import zlib
from pathlib import Path

import msgpack
import pytest
from cryptography.hazmat.primitives.ciphers.aead import AESCCM
from spake2 import SPAKE2_A

from conf.protocol.session.drop_reasons import DatagramError
from conf.protocol.session.packet import parse_datagram
from conf.protocol.session.server import SessionServer
from tools.golden.session import CODE, FOLDER, SENDER, invalid, stream, valid

VALID = {path.stem.removeprefix("session_"): path for path in sorted(FOLDER.glob("session_[!i]*.bin"))}
INVALID = {path.stem.removeprefix("session_invalid_"): path for path in sorted(FOLDER.glob("session_invalid_*.bin"))}


def golden(name: str) -> list[object]:
    """Return a golden datagram as msgpack sees it."""
    array: list[object] = msgpack.unpackb(VALID[name].read_bytes())
    return array


@pytest.mark.slow
def test_the_bytes_have_not_changed() -> None:
    assert {name: path.read_bytes() for name, path in VALID.items()} == valid()
    assert {name: path.read_bytes() for name, path in INVALID.items()} == invalid()


@pytest.mark.parametrize("path", VALID.values(), ids=VALID)
def test_a_valid_datagram_parses_and_no_truncation_of_it_does(path: Path) -> None:
    data = path.read_bytes()
    parse_datagram(data)
    for size in range(len(data)):
        with pytest.raises(DatagramError):
            parse_datagram(data[:size])


@pytest.mark.parametrize("name", INVALID)
def test_an_invalid_datagram_is_dropped_for_its_reason(name: str) -> None:
    receiver = SessionServer(CODE, stream("receiver"))
    receiver.receive_datagram(INVALID[name].read_bytes(), SENDER, 0.0)
    assert [str(reason) for reason in receiver.dropped] == [name.split("_")[0]]
    assert not receiver.datagrams_to_send(0.0)


def hkdf_expand(key: bytes, info: bytes, size: int) -> bytes:
    """RFC 5869, 2.3."""
    block, result = b"", b""
    while len(result) < size:
        block = hmac.digest(key, block + info + bytes([len(result) // 32 + 1]), "sha256")
        result += block
    return result[:size]


def test_an_independent_implementation_opens_the_golden_datagrams() -> None:
    """Nothing of conf is used but the golden files, the code and the seed of the sender's random bytes."""
    random = stream("sender")
    attempt = random(8)
    spake = SPAKE2_A(CODE.encode(), idA=b"conf sender", idB=b"conf receiver", entropy_f=random)
    share = spake.start()[1:]
    version, kind, hello = golden("hello")
    assert (version, kind) == (3, 0)
    assert isinstance(hello, bytes) and hello[:-4] == attempt + bytes(8) + share
    assert int.from_bytes(hello[-4:]) == zlib.crc32(VALID["hello"].read_bytes()[:-4])

    answer = golden("answer")[2]
    assert isinstance(answer, bytes) and answer[:8] == attempt
    key = spake.finish(b"B" + answer[8:40])
    transcript = hashlib.sha256(b"\x03conf senderconf receiver" + attempt + share + answer[8:40]).digest()
    secrets = hkdf_expand(hmac.digest(transcript, key, "sha256"), b"conf session", 128)
    from_sender, from_receiver, sender_proof, receiver_proof = (secrets[i : i + 32] for i in range(0, 128, 32))

    confirm, done = golden("confirm")[2], golden("done")[2]
    assert isinstance(confirm, bytes) and isinstance(done, bytes)
    session = done[8]
    assert confirm[:-4] == attempt + b"\0" + hmac.digest(sender_proof, b"\x03\0", "sha256")[:16]
    assert done[9:25] == hmac.digest(receiver_proof, bytes([3, session]), "sha256")[:16]

    expected = {"data_first": (0, 0), "data_full_counter": (201, 201), "data_short_counter": (202, 74)}
    for name, (counter, on_wire) in expected.items():
        assert golden(name)[:3] == [3, session, on_wire]
        assert open_independently(name, from_sender, counter) == b"motion"
    assert open_independently("data_long", from_sender, 203) == bytes(300)
    assert open_independently("data_to_sender", from_receiver, 0) == b"report"


def open_independently(name: str, secret: bytes, counter: int) -> bytes:
    data, sealed = VALID[name].read_bytes(), golden(name)[3]
    assert isinstance(sealed, bytes)
    material = hkdf_expand(secret, b"conf epoch", 53)
    cipher = AESCCM(material[:16], tag_length=8)
    return cipher.decrypt(material[16:21] + counter.to_bytes(8), sealed, data[: -len(sealed)])
