"""All voices together: who is there, who is loudest, how loud it is heard."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from conf.protocol.stream_clocks import PlayoutClock
from conf.protocol.voice.formats import VoiceFormat, VoiceFrame, VoiceState
from conf.protocol.voice.inbound import InboundVoice
from conf.receiver.voice.voice_mixer import VoiceMixer

CODEC2 = VoiceFormat("codec2", 3200, 20, 1, fixed_size=True)


class SilentVoice(InboundVoice):
    """A participant whose newest packet was in some format; each frame asked for is lost or absent."""

    def __init__(self, *, lost: bool = False) -> None:
        super().__init__()
        self.format = CODEC2
        self.state = VoiceState.TALKING
        self._lost = lost
        self._at = 0

    def frames_until(self, stream_time: float) -> list[VoiceFrame]:
        frames = []
        while self._lost and self._at * 0.02 < stream_time:
            frames.append(VoiceFrame(self._at * 0.02, CODEC2, None))
            self._at += 1
        return frames


@dataclass
class Stream:
    voice: InboundVoice = field(default_factory=SilentVoice)
    clock: PlayoutClock = field(default_factory=PlayoutClock)


def make(streams: dict[int, Stream]) -> VoiceMixer:
    return VoiceMixer(streams, np.random.default_rng(3))


def test_participants_come_and_go_with_the_streams() -> None:
    streams = {1: Stream()}
    mixer = make(streams)
    assert len(mixer.render(0.0, 160)) == 160 and mixer.participants.keys() == {1}
    streams[2] = Stream()
    del streams[1]
    mixer.render(0.01, 160)
    assert mixer.participants.keys() == {2}
    del streams[2]
    assert not mixer.render(0.02, 160).any() and mixer.participants == {} and mixer.loudest is None


def test_a_caller_without_voice_delays_nothing() -> None:
    quiet = Stream(voice=InboundVoice())
    talking = Stream()
    mixer = make({1: quiet, 2: talking})
    mixer.render(0.0, 160, output_delay_s=0.1)
    assert quiet.clock.extra_delay_s == 0.0
    assert talking.clock.extra_delay_s == pytest.approx(0.1 + mixer.participants[2].lookahead_s)


def test_volume_and_mute_change_what_is_heard() -> None:
    mixer = make({})
    samples = np.full(4, 1000, np.int16)
    assert mixer.audible(samples).tolist() == [1000] * 4
    mixer.change_volume(+1)
    assert mixer.audible(samples).tolist() == [1413] * 4  # 3 dB
    mixer.change_volume(-100)
    assert mixer.volume_db == -30.0 and mixer.audible(samples).tolist() == [32] * 4
    mixer.change_volume(+100)
    assert mixer.volume_db == 12.0 and mixer.audible(np.full(1, 30000, np.int16)).tolist() == [32767]
    mixer.muted = True
    assert not mixer.audible(samples).any()


def test_who_is_being_concealed_is_named() -> None:
    mixer = make({1: Stream(), 2: Stream(voice=SilentVoice(lost=True))})
    for index in range(60):
        mixer.render(index * 0.01, 160)
    assert mixer.concealing == [2]


def test_lips_stay_with_the_sound_while_it_is_stretched_to_a_longer_delay() -> None:
    stream = Stream(voice=SilentVoice(lost=True))
    mixer = make({1: stream})
    stream.clock.delay_s = 0.1
    playheads = []
    for index in range(400):
        now = 1.0 + index * 0.01
        if index == 50:
            stream.clock.delay_s += 0.2
        mixer.render(now, 160)
        playheads.append(stream.clock.motion_playhead(now))
    steps = np.diff(playheads)
    assert 0.0085 < steps.min() and steps.max() < 0.0105
    assert playheads[-1] == pytest.approx(stream.clock.playhead(now), abs=0.006)
