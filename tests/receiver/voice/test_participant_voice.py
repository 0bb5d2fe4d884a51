"""A participant's frames as continuous sound: in time, without clicks, concealed where frames are lost."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from conf.audio.samples import SAMPLE_RATE, Samples
from conf.errors import AudioError
from conf.protocol.voice.formats import VoiceFormat, VoiceFrame
from conf.receiver.voice.participant_voice import ParticipantVoice

FORMAT = VoiceFormat("pcm", 256_000, 20, 1, fixed_size=True)
FRAME = SAMPLE_RATE // 50
TONE_HZ = 200.0


def tone(start: float, count: int) -> Samples:
    times = start + np.arange(count) / SAMPLE_RATE
    return np.asarray(8000 * np.sin(2 * np.pi * TONE_HZ * times), np.int16)


@dataclass
class PcmDecoder:
    """Decodes samples to themselves, conceals with a constant, and is late by a delay."""

    delay_s: float = 0.0
    sample_rate: int = SAMPLE_RATE
    frame_samples: int = FRAME

    def decode(self, data: bytes, /) -> Samples:
        return np.frombuffer(data, np.int16)

    def conceal(self) -> Samples:
        return np.full(FRAME, 77, np.int16)


@dataclass
class FakeSource:
    """The frames of a tone from stream time 0 on, without those in `lost`; nothing is said in `pauses`."""

    lost: set[int] = field(default_factory=set)
    pauses: set[int] = field(default_factory=set)
    end: int = 10_000
    noise_level: int = 127
    next: int = 0
    delay_s: float = 0.0

    def frames_until(self, stream_time: float, /) -> list[VoiceFrame]:
        frames = []
        while self.next * 0.02 < stream_time and self.next < self.end:
            if self.next not in self.pauses:
                data = tone(self.next * 0.02 - self.delay_s, FRAME).tobytes()
                frames.append(VoiceFrame(self.next * 0.02, FORMAT, None if self.next in self.lost else data))
            self.next += 1
        return frames

    def awaits_packet(self, stream_time: float, /) -> bool:
        return stream_time > self.end * 0.02


def make(source: FakeSource, *, delay_s: float = 0.0) -> ParticipantVoice:
    return ParticipantVoice(source, np.random.default_rng(1), decoders=lambda *_: PcmDecoder(delay_s))


def render(voice: ParticipantVoice, seconds: float, *, begin: float = 0.0, block: int = 160) -> Samples:
    blocks = range(round(seconds * SAMPLE_RATE / block))
    return np.concatenate([voice.render(begin + i * block / SAMPLE_RATE, block) for i in blocks])


@pytest.mark.parametrize("block", [160, 533])
def test_frames_are_heard_at_their_time(block: int) -> None:
    sound = render(make(FakeSource()), 1.0, block=block)
    assert np.array_equal(sound, tone(0.0, len(sound)))


@pytest.mark.parametrize("shift_s", [-0.0041, -0.0021, 0.0004, 0.0021])
@pytest.mark.parametrize("block", [37, 160, 300])
def test_a_frame_that_starts_a_little_off_follows_without_a_gap(shift_s: float, block: int) -> None:
    """As after a pause that is no multiple of a frame: the boundaries of frames then lie anywhere between blocks."""
    sound = render(make(FakeSource(pauses=set(range(10)))), 1.0, begin=shift_s, block=block)
    spoken = np.flatnonzero(sound)  # the tone is 0 for one sample at a time
    assert len(spoken) > 0.7 * SAMPLE_RATE and np.diff(spoken).max() == 2


def test_a_codecs_delay_is_made_good() -> None:
    sound = render(make(FakeSource(delay_s=0.018), delay_s=0.018), 1.0)
    assert np.array_equal(sound[800:], tone(0.05, len(sound) - 800))


def test_lost_frames_are_concealed_and_counted() -> None:
    voice = make(FakeSource(lost={10, 11, 12, 13, 14, 15}))
    sound = render(voice, 0.6)
    assert (sound[10 * FRAME : 16 * FRAME] == 77).all()
    assert np.array_equal(sound[16 * FRAME :], tone(0.32, len(sound) - 16 * FRAME))
    assert voice.concealed_s == pytest.approx(0.12)
    render(voice, 1.2, begin=0.6)
    assert voice.concealed_s == 0.0


def test_a_packet_is_awaited_as_soon_as_the_next_samples_need_it() -> None:
    voice = make(FakeSource(end=5))
    assert not voice.awaits_packet(0.0, 160)
    render(voice, 0.08)
    assert not voice.awaits_packet(0.08, 320)
    assert voice.awaits_packet(0.08, 321)


def test_sound_that_is_shrunk_awaits_its_packet_earlier() -> None:
    voice = make(FakeSource(end=5))
    render(voice, 0.06)
    assert not voice.awaits_packet(0.06, 600)
    assert voice.awaits_packet(0.06 + 0.05, 600)  # 50 ms late: a tenth more samples, and those that are compared


def test_pauses_are_filled_with_noise_of_the_level_told() -> None:
    source = FakeSource(pauses=set(range(10, 40)), noise_level=50)
    sound = render(make(source), 1.0)
    noise = sound[12 * FRAME : 40 * FRAME].astype(float)
    assert 20 * np.log10(noise.std() / 32768) == pytest.approx(-50, abs=2)
    assert np.array_equal(sound[40 * FRAME :], tone(0.8, len(sound) - 40 * FRAME))


@pytest.mark.parametrize("step", [0.08, -0.08])
def test_a_change_of_the_delay_stretches_the_sound_without_a_click(step: float) -> None:
    voice = make(FakeSource())
    before = render(voice, 1.0)
    after = render(voice, 3.0, begin=1.0 + step)
    sound = np.concatenate([before, after]).astype(float)
    assert np.abs(np.diff(sound)).max() < 2 * np.pi * TONE_HZ / SAMPLE_RATE * 8000 * 1.3
    end = voice.render(4.0 + step, 1600).astype(float)
    times = 4.0 + step + np.arange(1600) / SAMPLE_RATE
    phase = np.angle(np.exp(-2j * np.pi * TONE_HZ * times) @ end) + np.pi / 2  # of the tone that is due
    assert abs(np.angle(np.exp(1j * phase))) < 2 * np.pi * TONE_HZ * 0.0055


def test_a_large_jump_of_the_clock_is_followed_at_once() -> None:
    voice = make(FakeSource())
    render(voice, 0.5)
    sound = render(voice, 0.5, begin=2.5)
    assert np.array_equal(sound[800:], tone(2.55, len(sound) - 800))


def test_after_the_voice_has_ended_there_is_silence() -> None:
    voice = make(FakeSource(end=10))
    sound = render(voice, 1.0)
    assert not sound[11 * FRAME :].any() and voice.level_dbfs == -96.0


def test_a_codec_that_is_unknown_is_silent_and_said() -> None:
    def refuse(codec: str, bit_rate: int, frame_ms: int) -> PcmDecoder:
        raise AudioError(f"voice in a codec unknown here ({codec})")

    voice = ParticipantVoice(FakeSource(), np.random.default_rng(1), decoders=refuse)
    assert not render(voice, 0.2).any()
    assert voice.unknown_codec == "voice in a codec unknown here (pcm)"
