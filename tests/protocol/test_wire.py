import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.feedback import Report
from conf.protocol.messages import (
    Body,
    Feedback,
    KeepAlive,
    MotionPayload,
    MotionWithChunk,
    PortraitAck,
    PortraitChunk,
    Presence,
    StreamParameters,
)
from conf.protocol.wire import MAX_BODY, decode_body, encode_body

BODIES: list[Body] = [
    MotionPayload(frame_number=77, payload=b"\x01\x02\x03"),
    StreamParameters(320, 240, 15.0, 50, (6.4, 4.2, 2.0, 5.1, 1.1), clock=12.345),
    KeepAlive(3.25, Presence.NO_FACE),
    Feedback(Report(highest=100, missing=5, lost=7, jitter_ms=12, ack_delay_ms=30), refresh=True),
]
CARRIED: list[Body] = [
    PortraitChunk(b"piece"),
    PortraitAck(b"answer"),
    MotionWithChunk(MotionPayload(3, b"motion"), PortraitChunk(b"piece")),
]
NAMES = [type(body).__name__ for body in BODIES]


@pytest.mark.parametrize("body", [*BODIES, *CARRIED], ids=lambda body: type(body).__name__)
def test_a_body_comes_back(body: Body) -> None:
    assert decode_body(encode_body(body)) == body


@pytest.mark.parametrize("body", BODIES[1:], ids=NAMES[1:])
def test_every_truncation_and_every_tail_is_refused(body: Body) -> None:
    data = encode_body(body)
    for length in range(len(data)):
        with pytest.raises(ProtocolError):
            decode_body(data[:length])
    with pytest.raises(ProtocolError):
        decode_body(data + b"\0")


def test_motion_costs_one_byte_beside_its_payload() -> None:
    assert len(encode_body(BODIES[0])) == 4


@given(st.binary(max_size=MAX_BODY + 10))
def test_junk_is_refused_or_understood(data: bytes) -> None:
    try:
        decode_body(data)
    except ProtocolError:
        pass


VALUES = (
    st.integers(-(2**63), 2**64 - 1)
    | st.binary(max_size=32)
    | st.none()
    | st.floats()
    | st.lists(st.integers(0, 1 << 40))
)


@given(st.integers(0, 127), st.lists(VALUES, max_size=12))
def test_well_formed_nonsense_is_refused_or_understood(kind: int, values: list[object]) -> None:
    try:
        decode_body(bytes((kind,)) + msgpack.packb(values))
    except ProtocolError:
        pass
