import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.messages import KeepAlive, MotionFrame, Presence, StreamParameters
from conf.protocol.wire import MAX_DATAGRAM, Datagram, decode, encode

PARAMETERS = StreamParameters(320, 240, 15.0, 50, (6.4, 4.2, 2.0, 5.1, 1.1))
FRAME = MotionFrame(12.345, np.arange(150, dtype=np.float32).reshape(50, 3) - 75, np.array([0.1, -0.2, 0, 0.3, 0, -3]))
MESSAGES = [PARAMETERS, FRAME, KeepAlive(3.25, Presence.NO_FACE)]


@pytest.mark.parametrize("message", MESSAGES, ids=lambda m: type(m).__name__)
def test_a_message_comes_back(message: object) -> None:
    back = decode(encode(Datagram(70_000, message)))
    assert back.sequence == 70_000
    assert type(back.message) is type(message)
    for name, value in vars(message).items():
        if isinstance(value, Presence):
            assert getattr(back.message, name) is value
        else:
            np.testing.assert_allclose(getattr(back.message, name), value, atol=1e-3)


def test_a_frame_stays_under_its_budget() -> None:
    assert len(encode(Datagram(2**31, MotionFrame(1e6, FRAME.displacements, FRAME.pose)))) <= 340


@pytest.mark.parametrize("message", MESSAGES, ids=lambda m: type(m).__name__)
def test_every_truncation_is_refused(message: object) -> None:
    data = encode(Datagram(5, message))
    for length in range(len(data)):
        with pytest.raises(ProtocolError):
            decode(data[:length])
    with pytest.raises(ProtocolError):
        decode(data + b"\0")


@given(st.binary(max_size=MAX_DATAGRAM + 10))
def test_junk_is_refused_or_understood(data: bytes) -> None:
    try:
        decode(data)
    except ProtocolError:
        pass


VALUES = st.integers(-(2**63), 2**64 - 1) | st.binary(max_size=320) | st.none() | st.floats() | st.lists(st.integers())


@given(st.lists(VALUES, max_size=9))
def test_well_formed_nonsense_is_refused_or_understood(values: list[object]) -> None:
    try:
        decode(msgpack.packb([1, *values]))
    except ProtocolError:
        pass


@given(st.integers(0, 10_000), st.integers(0, 255), st.sampled_from(MESSAGES))
def test_a_flipped_byte_never_raises_anything_else(at: int, value: int, message: object) -> None:
    data = bytearray(encode(Datagram(5, message)))
    data[at % len(data)] = value
    try:
        decode(bytes(data))
    except ProtocolError:
        pass
