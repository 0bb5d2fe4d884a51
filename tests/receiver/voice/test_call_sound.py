"""Sound for a loudspeaker and for a clip: as much as time passes, each sample with the time at which it is heard."""

from itertools import pairwise

import numpy as np
import pytest

from conf.audio.samples import SAMPLE_RATE, AudioBlock, Samples
from conf.errors import AudioError
from conf.receiver.voice.call_sound import (
    BLOCK,
    LATEST_S,
    MAX_TARGET_S,
    PACKET_POLL_S,
    POLL_S,
    REQUEST_MARGIN_S,
    RESERVE_S,
    RETRY_S,
    ClipSound,
    LoudspeakerSound,
)
from conf.receiver.voice.voice_mixer import VoiceMixer

TARGET_S = RESERVE_S + 0.0075


class CountingMixer(VoiceMixer):
    """A mixer whose sound is the index of each sample; it notes when each block will be heard."""

    def __init__(self) -> None:
        super().__init__({}, np.random.default_rng(1))
        self.asked: list[tuple[float, int, float]] = []
        self._count = 0
        self.awaits = False

    def render(self, heard_at: float, count: int, *, output_delay_s: float = 0.0) -> Samples:
        self.asked.append((heard_at, count, output_delay_s))
        self._count += count
        return np.arange(self._count - count, self._count).astype(np.int16)

    def awaits_packet(self, heard_at: float, count: int) -> bool:
        return self.awaits


class FakeOutput:
    """A loudspeaker with 50 ms behind its queue. gone : whether it was unplugged"""

    request_s, device_latency_s = TARGET_S - RESERVE_S, 0.05

    def __init__(self) -> None:
        self.queue = np.zeros(0, np.int16)
        self.closed = self.gone = False
        self.next_request_s = 0.0

    @property
    def queued_s(self) -> float:
        return len(self.queue) / SAMPLE_RATE

    def read_played(self) -> AudioBlock | None:
        return AudioBlock(7.0, self.queue)

    @property
    def latency_s(self) -> float:
        return self.queued_s + 0.05

    def check(self) -> None:
        if self.gone:
            raise AudioError("the loudspeaker is gone")

    def write(self, samples: Samples, /) -> None:
        self.queue = np.concatenate([self.queue, samples])

    def play(self, count: int) -> Samples:
        played, self.queue = self.queue[:count], self.queue[count:]
        return played

    def close(self) -> None:
        self.closed = True


def test_the_queue_is_filled_to_its_target_and_times_follow_each_other() -> None:
    mixer, output = CountingMixer(), FakeOutput()
    sound = LoudspeakerSound(mixer, output, clock=lambda: 100.0)
    sound.fill()
    assert len(output.queue) == TARGET_S * SAMPLE_RATE
    assert mixer.asked == [(pytest.approx(100.05), 2 * BLOCK, pytest.approx(TARGET_S + 0.05))]
    sound.fill()
    assert len(mixer.asked) == 1
    assert output.play(BLOCK).tolist() == list(range(BLOCK))
    sound.fill()
    assert mixer.asked[1:] == [(pytest.approx(100.06), BLOCK, pytest.approx(TARGET_S + 0.05))]


def test_the_next_fill_waits_for_the_devices_request() -> None:
    output = FakeOutput()
    output.next_request_s = 0.02
    sound = LoudspeakerSound(CountingMixer(), output)
    assert sound.wait_s == pytest.approx(0.02 + REQUEST_MARGIN_S)
    output.next_request_s = 0.0  # overdue: it comes at any time
    assert sound.wait_s == POLL_S
    sound.fault = "the loudspeaker is gone"
    assert sound.wait_s == RETRY_S


def test_a_late_packet_is_waited_for_until_the_device_needs_sound() -> None:
    mixer, output = CountingMixer(), FakeOutput()
    sound = LoudspeakerSound(mixer, output, clock=lambda: 0.0)
    mixer.awaits, output.next_request_s = True, LATEST_S + 0.001
    sound.fill()
    assert not mixer.asked and sound.wait_s == PACKET_POLL_S
    output.next_request_s = LATEST_S
    sound.fill()
    assert output.queued_s == pytest.approx(TARGET_S)
    assert sound.wait_s == pytest.approx(LATEST_S + REQUEST_MARGIN_S)


def test_after_the_device_ran_out_of_sound_more_is_kept_ready_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conf.receiver.voice.call_sound.TARGET_DECAY", 0.999)
    mixer, output = CountingMixer(), FakeOutput()
    sound = LoudspeakerSound(mixer, output, clock=lambda: 0.0)
    sound.fill()
    output.play(SAMPLE_RATE)
    sound.fill()
    assert output.queued_s == pytest.approx(TARGET_S * 1.5, abs=0.01)
    assert mixer.asked[-1][2] == pytest.approx(TARGET_S * 1.5 + 0.05, abs=0.002)
    for _ in range(20):
        output.play(SAMPLE_RATE)
        sound.fill()
    assert output.queued_s <= MAX_TARGET_S + 0.01
    for _ in range(2500):
        output.play(BLOCK)
        sound.fill()
    assert output.queued_s == pytest.approx(TARGET_S)


def test_what_is_heard_is_recorded_at_full_volume() -> None:
    mixer, output = CountingMixer(), FakeOutput()
    sound = LoudspeakerSound(mixer, output, clock=lambda: 0.0)
    mixer.muted = True
    sound.record(True)
    sound.fill()
    assert not output.play(BLOCK).any()
    sound.fill()
    (block,) = sound.recorded(0.055)
    assert block.timestamp == pytest.approx(0.05) and block.samples.tolist() == list(range(2 * BLOCK))
    (block,) = sound.recorded(1.0)
    assert block.timestamp == pytest.approx(0.06) and block.samples.tolist() == list(range(2 * BLOCK, 3 * BLOCK))
    sound.record(False)
    sound.fill()
    assert sound.recorded(1.0) == []


def test_the_thread_plays_until_it_is_closed() -> None:
    mixer, output = CountingMixer(), FakeOutput()
    with LoudspeakerSound(mixer, output) as sound:
        while not len(output.queue):
            pass
    assert output.closed and sound.fault == ""


def test_a_loudspeaker_that_is_gone_is_said_and_ends_no_call() -> None:
    output = FakeOutput()
    output.gone = True
    with LoudspeakerSound(CountingMixer(), output) as sound:
        while not sound.fault:
            pass
    assert sound.fault == "the loudspeaker is gone"


def test_a_loudspeaker_that_calls_for_no_sound_any_more_is_noticed() -> None:
    output = FakeOutput()
    sound = LoudspeakerSound(CountingMixer(), output, clock=lambda: 0.0)
    sound.fill()
    output.gone = True  # with a full queue
    with pytest.raises(AudioError, match="the loudspeaker is gone"):
        sound.fill()


def test_a_loudspeaker_that_comes_back_plays_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conf.receiver.voice.call_sound.RETRY_S", 0.001)
    gone, back, attempts = FakeOutput(), FakeOutput(), list[str]()
    gone.gone = True

    def reopen() -> FakeOutput:
        attempts.append(sound.fault)
        if len(attempts) < 3:
            raise AudioError("there is no speaker here")
        return back

    with LoudspeakerSound(CountingMixer(), gone, reopen=reopen) as sound:
        while not len(back.queue) or sound.fault:
            pass
    assert attempts == ["the loudspeaker is gone"] * 3 and gone.closed and back.closed


def test_a_clip_gets_as_much_sound_as_time_has_passed() -> None:
    mixer = CountingMixer()
    sound = ClipSound(mixer)
    assert sound.recorded(10.0) == []
    blocks = [block for now in np.arange(1, 31) / 30 + 10.0 for block in sound.recorded(float(now))]
    samples = np.concatenate([block.samples for block in blocks])
    assert samples.tolist() == list(range(len(samples))) and len(samples) == pytest.approx(SAMPLE_RATE, abs=1)
    assert blocks[0].timestamp == 10.0
    for block, following in pairwise(blocks):
        assert following.timestamp == pytest.approx(block.timestamp + len(block.samples) / SAMPLE_RATE)


def test_after_a_long_stop_a_clips_sound_goes_on_from_now() -> None:
    sound = ClipSound(CountingMixer())
    sound.recorded(0.0)
    assert sound.recorded(5.0) == []
    assert len(sound.recorded(5.125)[0].samples) == 2000


def test_what_was_played_is_the_reference_of_echo_cancellation() -> None:
    sound = LoudspeakerSound(CountingMixer(), FakeOutput(), clock=lambda: 0.0)
    sound.fill()
    played = sound.read_played()
    assert played is not None and played.timestamp == 7.0 and len(played.samples) == TARGET_S * SAMPLE_RATE
    assert ClipSound(CountingMixer()).read_played() is None
