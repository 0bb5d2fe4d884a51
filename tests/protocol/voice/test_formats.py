import pytest

from conf.errors import ProtocolError
from conf.protocol.voice.formats import MAX_BIT_RATE, MAX_PACKET_MS, VoiceFormat, VoiceState

OPUS = VoiceFormat("opus", 9000, 60, 2, fixed_size=False)
CODEC2 = VoiceFormat("codec2", 700, 40, 3, fixed_size=True)


@pytest.mark.parametrize(
    ("voice_format", "packet_ms", "frame_bits", "nominal_bytes"),
    [
        (OPUS, 120, 540, 68 + 1 + 68),
        (VoiceFormat("opus", 9000, 60, 1, fixed_size=False), 60, 540, 68),
        (VoiceFormat("opus", 5000, 60, 1, fixed_size=False, repeated=1), 60, 300, 38 + 1 + 38),
        (CODEC2, 120, 28, 11),  # 84 bits
        (VoiceFormat("codec2", 1200, 40, 5, fixed_size=True, repeated=5), 200, 48, 60),
        (VoiceFormat("codec2", 1200, 40, 4, fixed_size=True, repeated=2), 160, 48, 36),
        (VoiceFormat("codec2", 3200, 20, 10, fixed_size=True), 200, 64, 80),
    ],
)
def test_durations_and_sizes(voice_format: VoiceFormat, packet_ms: int, frame_bits: int, nominal_bytes: int) -> None:
    voice_format.check()
    assert (voice_format.packet_ms, voice_format.packet_s) == (packet_ms, packet_ms / 1000)
    assert (voice_format.frame_bits, voice_format.nominal_bytes) == (frame_bits, nominal_bytes)
    assert voice_format.coverage_s == pytest.approx((packet_ms + voice_format.repeated * voice_format.frame_ms) / 1000)


@pytest.mark.parametrize(
    ("voice_format", "message"),
    [
        (VoiceFormat("", 9000, 60, 1, fixed_size=False), "the name of a voice codec is not 1 to 16 ASCII characters"),
        (VoiceFormat("a" * 17, 9000, 60, 1, fixed_size=False), "the name of a voice codec"),
        (VoiceFormat("opüs", 9000, 60, 1, fixed_size=False), "the name of a voice codec"),
        (VoiceFormat("op\ns", 9000, 60, 1, fixed_size=False), "the name of a voice codec"),
        (VoiceFormat("opus", 9000, 60, 0, fixed_size=False), "a voice format out of range"),
        (VoiceFormat("opus", 0, 60, 1, fixed_size=False), "a voice format out of range"),
        (VoiceFormat("opus", 9000, 0, 1, fixed_size=False), "a voice format out of range"),
        (VoiceFormat("opus", MAX_BIT_RATE + 1, 20, 1, fixed_size=False), "a voice format out of range"),
        (VoiceFormat("codec2", 40, 20, 1, fixed_size=True), "a voice format out of range"),  # less than a bit a frame
        (VoiceFormat("opus", 9000, 60, 17, fixed_size=False), "voice packets of this duration are not allowed"),
        (VoiceFormat("opus", 9000, 60, 2, fixed_size=False, repeated=3), "repeats more than the one before"),
        (VoiceFormat("opus", 9000, 60, 2, fixed_size=False, repeated=-1), "repeats more than the one before"),
        (VoiceFormat("opus", 9000, 10, 3, fixed_size=False), "voice packets of this duration are not allowed"),
    ],
)
def test_formats_that_a_receiver_must_not_accept(voice_format: VoiceFormat, message: str) -> None:
    with pytest.raises(ProtocolError, match=message):
        voice_format.check()


@pytest.mark.parametrize(
    "voice_format",
    [
        VoiceFormat("a", 9000, 20, 1, fixed_size=False),
        VoiceFormat("a" * 16, 9000, 20, 1, fixed_size=False),
        VoiceFormat("opus", MAX_BIT_RATE, 20, 1, fixed_size=False),
        VoiceFormat("bits", 50, 20, 1, fixed_size=True),  # one bit a frame
        VoiceFormat("short", 1000, 1, 20, fixed_size=True),
        VoiceFormat("slow", 1, 1000, 1, fixed_size=True),
    ],
)
def test_formats_at_the_limits_are_accepted(voice_format: VoiceFormat) -> None:
    voice_format.check()


def test_a_packet_of_a_second_is_the_longest() -> None:
    VoiceFormat("codec2", 700, 20, MAX_PACKET_MS // 20, fixed_size=True).check()


def test_the_states_are_those_of_the_wire() -> None:
    names = {state.value: state.name for state in VoiceState}
    assert names == {0: "OFF", 1: "SILENT", 2: "TALKING", 3: "MUTED", 4: "NO_ROOM"}
