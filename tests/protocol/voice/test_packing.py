import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.voice.formats import VoiceFormat
from conf.protocol.voice.packing import pack_frames, unpack_frames
from tests.protocol.independent_decoder import read_voice_frames

OPUS = VoiceFormat("opus", 9000, 60, 1, fixed_size=False)


def codec2(bit_rate: int) -> VoiceFormat:
    return VoiceFormat("codec2", bit_rate, 40, 1, fixed_size=True)


@pytest.mark.slow
@given(st.integers(1, 2000), st.lists(st.integers(0), min_size=1, max_size=24))
def test_fixed_frames_come_back_and_take_no_more_bits_than_they_have(bits: int, values: list[int]) -> None:
    voice_format = codec2(bits * 25)
    size = -(-bits // 8)
    frames = [((value % (1 << bits)) << 8 * size - bits).to_bytes(size) for value in values]
    data = pack_frames(frames, voice_format)
    assert len(data) == -(-bits * len(frames) // 8)
    assert unpack_frames(data, voice_format, len(frames)) == frames
    assert read_voice_frames(data, len(frames), fixed_bits=bits) == frames


@pytest.mark.slow
@given(st.lists(st.binary(max_size=255), min_size=1, max_size=12))
def test_variable_frames_come_back(frames: list[bytes]) -> None:
    data = pack_frames(frames, OPUS)
    assert len(data) == sum(map(len, frames)) + len(frames) - 1
    assert unpack_frames(data, OPUS, len(frames)) == frames
    assert read_voice_frames(data, len(frames), fixed_bits=None) == frames


@pytest.mark.parametrize("cut", [-1, 1])
def test_a_fixed_packet_of_another_length_is_rejected(cut: int) -> None:
    data = pack_frames([b"\xff\xff\xff\xf0"] * 3, codec2(700))
    changed = data[:cut] if cut < 0 else data + bytes(cut)
    with pytest.raises(ProtocolError, match="a voice packet of the wrong length"):
        unpack_frames(changed, codec2(700), 3)


def test_padding_bits_must_be_zero() -> None:
    data = pack_frames([b"\xff\xff\xff\xf0"] * 3, codec2(700))
    with pytest.raises(ProtocolError, match="a voice packet of the wrong length"):
        unpack_frames(data[:-1] + bytes((data[-1] | 1,)), codec2(700), 3)


@pytest.mark.parametrize("data", [b"", b"\3", b"\3ab"])
def test_a_variable_packet_cut_off_is_rejected(data: bytes) -> None:
    with pytest.raises(ProtocolError, match="a voice packet cut off"):
        unpack_frames(data, OPUS, 2)


def test_frames_of_another_size_are_the_callers_fault() -> None:
    with pytest.raises(ValueError, match="a voice frame of 28 bits has 4 bytes, not 3"):
        pack_frames([b"abc"], codec2(700))
    with pytest.raises(ValueError, match="a voice frame is longer than 255 bytes"):
        pack_frames([bytes(256)], OPUS)


@pytest.mark.slow
@given(st.binary(max_size=80), st.integers(1, 20), st.booleans())
def test_any_bytes_are_frames_or_a_protocol_error(data: bytes, count: int, is_fixed: bool) -> None:
    voice_format = codec2(1200) if is_fixed else OPUS
    try:
        frames = unpack_frames(data, voice_format, count)
    except ProtocolError:
        return
    assert len(frames) == count and pack_frames(frames, voice_format) == data
