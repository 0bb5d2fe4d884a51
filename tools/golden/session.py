"""Write the golden datagrams of the session to tests/data/session_*.bin. The output is constant.

    python tools/golden/session.py

Random bytes come from SHA-256 in counter mode over a label, so that the datagrams can be reproduced from WIRE.md.
"""

import hashlib
from collections.abc import Callable
from itertools import count
from pathlib import Path

from conf.protocol.session.client import SenderSession
from conf.protocol.session.handshake import Refusal
from conf.protocol.session.packet import Kind, handshake_datagram
from conf.protocol.session.server import SessionServer

CODE = "acorn-tulip-river-42"
SENDER, RECEIVER = ("198.51.100.7", 40000), ("192.0.2.1", 5005)
FOLDER = Path(__file__).resolve().parents[2] / "tests" / "data"


def stream(label: str) -> Callable[[int], bytes]:
    """Return a function: size -> the next bytes of SHA-256(label | 0) | SHA-256(label | 1) ..., counters as 4 B."""
    blocks, rest = count(), b""

    def read(size: int) -> bytes:
        nonlocal rest
        while len(rest) < size:
            rest += hashlib.sha256(label.encode() + next(blocks).to_bytes(4)).digest()
        result, rest = rest[:size], rest[size:]
        return result

    return read


def valid() -> dict[str, bytes]:
    """Return a complete handshake, data with each form of header, and two refusals, by name."""
    receiver = SessionServer(CODE, stream("receiver"))
    sender = SenderSession(CODE, RECEIVER, stream("sender"), 0.0)
    sent = []
    while sender.session is None:
        for data, _ in sender.datagrams_to_send(0.0):
            sent.append(data)
            receiver.receive_datagram(data, SENDER, 0.0)
        for data, _ in receiver.datagrams_to_send(0.0):
            sent.append(data)
            sender.receive_datagram(data, RECEIVER, 0.0)
    names = ("hello", "retry", "hello_with_cookie", "answer", "confirm", "done")
    golden = dict(zip(names, sent, strict=True))
    bodies = [_seal(sender, b"motion") for _ in range(202)]
    sender.acknowledge(199)
    report = receiver.seal_body(sender.session, b"report")
    assert report is not None
    attempt = sent[0][5:13]
    return golden | {
        "data_first": bodies[0],
        "data_full_counter": bodies[201],
        "data_short_counter": _seal(sender, b"motion"),
        "data_long": _seal(sender, bytes(300)),
        "data_to_sender": report.datagram,
        "refused_wrong_code": handshake_datagram(Kind.REFUSED, attempt, Refusal.WRONG_CODE, 4),
        "unknown_session": handshake_datagram(Kind.UNKNOWN, sender.session),
    }


def invalid() -> dict[str, bytes]:
    """Return datagrams that must be dropped: named `<reason>_<error>`."""
    good = valid()
    data, hello = good["data_first"], good["hello"]
    return {
        "size_9_bytes": data[:9],
        "size_1201_bytes": data + bytes(1201 - len(data)),
        "version_1": b"\x94\x01" + data[2:],
        "syntax_session_128": data[:2] + b"\x80" + data[3:],
        "syntax_long_counter": data[:3] + b"\xcc" + data[3:],
        "syntax_bin16": data[:4] + b"\xc5\x00" + data[5:],
        "syntax_string": data[:4] + b"\xd9" + data[5:],
        "syntax_truncated_data": data[:-1],
        "syntax_truncated_hello": hello[:-1],
        "syntax_kind_7": hello[:2] + b"\x07" + hello[3:],
        "checksum_hello": hello[:20] + b"\xff" + hello[21:],
    }


def _seal(sender: SenderSession, body: bytes) -> bytes:
    sealed = sender.seal_body(body)
    assert sealed is not None
    return sealed.datagram


def main() -> None:
    """Write the files."""
    FOLDER.mkdir(exist_ok=True)
    for name, data in valid().items():
        (FOLDER / f"session_{name}.bin").write_bytes(data)
    for name, data in invalid().items():
        (FOLDER / f"session_invalid_{name}.bin").write_bytes(data)


if __name__ == "__main__":
    main()
