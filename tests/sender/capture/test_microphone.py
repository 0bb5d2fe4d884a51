"""The microphone of silence that every machine has."""

import time
from collections.abc import Callable

import numpy as np
import pytest

from conf.audio.devices import NULL_DEVICE
from conf.audio.samples import SAMPLE_RATE, AudioBlock
from conf.errors import AudioError
from conf.sender.capture.microphone import RETRY_S, SETTLING_READS, MicrophoneSource


@pytest.mark.slow
def test_captured_blocks_follow_each_other_on_the_clock() -> None:
    microphone = MicrophoneSource(NULL_DEVICE)
    begin = time.monotonic()
    blocks: list[AudioBlock] = []
    while sum(len(block.samples) for block in blocks) < SAMPLE_RATE // 5:
        blocks += microphone.read(time.monotonic())
    microphone.close()
    assert begin - 0.2 < blocks[0].timestamp < time.monotonic()
    assert all(not block.samples.any() for block in blocks)


class Silence:
    """A device with 10 ms of silence, captured until just now."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock

    def read(self) -> AudioBlock:
        return AudioBlock(self._clock() - 0.01, np.zeros(160, np.int16))


def test_beside_a_clip_the_times_are_those_of_its_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conf.sender.capture.microphone.open_microphone", lambda device, clock: Silence(clock))
    now = 1000.0
    beside_camera = MicrophoneSource(clock=lambda: now)
    beside_clip = MicrophoneSource(clock=lambda: now, live_frames=False)
    assert beside_camera.read(999.97)[0].timestamp == pytest.approx(999.99)  # a camera's frames come late
    assert beside_clip.read(2.48) == []  # the first frame took 20 ms: `until` is as old
    for _ in range(SETTLING_READS - 2):
        assert beside_clip.read(2.5) == []
    assert beside_clip.read(2.5)[0].timestamp == pytest.approx(2.49)
    now = 1004.0
    assert beside_clip.read(6.501)[0].timestamp == pytest.approx(6.49)  # a loop that is late changes no time


def test_a_microphone_that_is_gone_is_opened_again_when_it_is_back(monkeypatch: pytest.MonkeyPatch) -> None:
    class Unplugged(Silence):
        closed = False

        def read(self) -> AudioBlock:
            raise AudioError("the microphone gives no sound any more")

        def close(self) -> None:
            self.closed = True

    now, opened = 1000.0, list[object]()
    unplugged = Unplugged(lambda: now)
    devices = [unplugged, None, Silence(lambda: now)]

    def open_next(name: str | None, clock: object) -> object:
        opened.append(device := devices[len(opened)])
        if device is None:
            raise AudioError("there is no microphone here")
        return device

    monkeypatch.setattr("conf.sender.capture.microphone.open_microphone", open_next)
    source = MicrophoneSource(clock=lambda: now)
    for seconds in (0.0, 0.1, RETRY_S):
        now = 1000.0 + seconds
        with pytest.raises(AudioError, match="gives no sound any more"):
            source.read(now)
        if source._opening:
            source._opening.join()
    assert unplugged.closed and len(opened) == 2  # at once, and in vain
    with pytest.raises(AudioError, match="gives no sound any more"):
        source.read(now := 1002.2)
    assert source._opening is not None
    source._opening.join()
    assert len(opened) == 3 and source.read(now)[0].timestamp == pytest.approx(now - 0.01)


def test_a_microphone_that_is_not_there_is_refused() -> None:
    with pytest.raises(AudioError, match="there is no microphone"):
        MicrophoneSource("no such microphone")
