"""The microphone of silence that every machine has."""

import time

import pytest

from conf.audio.devices import NULL_DEVICE
from conf.audio.samples import SAMPLE_RATE, AudioBlock
from conf.errors import AudioError
from conf.sender.capture.microphone import MicrophoneSource


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


def test_a_microphone_that_is_not_there_is_refused() -> None:
    with pytest.raises(AudioError, match="there is no microphone"):
        MicrophoneSource("no such microphone")
