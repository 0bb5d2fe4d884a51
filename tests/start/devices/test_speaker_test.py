"""The test tone: what is played, for how long, and what is said where it cannot be."""

from typing import Any

import numpy as np
import pytest

from conf.audio.devices import Speaker
from conf.audio.samples import SAMPLE_RATE, AudioBlock, Samples
from conf.errors import AudioError
from conf.start.devices.speaker_test import AMPLITUDE, NOTE_S, NOTES_HZ, SpeakerTest, make_test_tone


class FakeSpeaker:
    """A speaker. idle_reads : how often it is asked what it has played before it takes the tone"""

    device_latency_s = 0.05

    def __init__(self, idle_reads: int = 0) -> None:
        self.written: list[Samples] = []
        self.closed = self.is_gone = False
        self.idle_reads = idle_reads

    @property
    def queued_s(self) -> float:
        return 1.0 if self.idle_reads else 0.0

    def check(self) -> None:
        if self.is_gone:
            raise AudioError("HDMI plays no sound any more: plug it in again, or name another device.")

    def write(self, samples: Samples, /) -> None:
        self.written.append(samples)

    def read_played(self) -> AudioBlock | None:
        if self.idle_reads:
            self.idle_reads -= 1
            return None
        return AudioBlock(0.0, self.written[-1])

    def __enter__(self) -> "FakeSpeaker":
        return self

    def __exit__(self, *_: object) -> None:
        self.closed = True


def test_the_tone_is_played_once() -> None:
    speaker: Any = FakeSpeaker()
    test = SpeakerTest("HDMI", opener=lambda name: speaker)
    test._device._thread.join()
    assert len(speaker.written) == 1 and speaker.closed and not test.is_playing
    assert test.error == "" and test.level == 0  # of a tone that has ended
    assert test._meter.level > 0.7
    assert test.close()


def test_the_tone_is_heard_to_its_end_when_the_device_starts_late() -> None:
    speaker: Any = FakeSpeaker(idle_reads=5)
    test = SpeakerTest("HDMI", opener=lambda name: speaker)
    test._device._thread.join()
    assert speaker.idle_reads == 0 and test._meter.level > 0.7 and test.error == ""


def test_a_speaker_that_is_gone_ends_the_tone_with_a_reason() -> None:
    speaker: Any = FakeSpeaker(idle_reads=1_000_000)
    speaker.is_gone = True
    test = SpeakerTest("HDMI", opener=lambda name: speaker)
    test._device._thread.join()
    assert test.error.startswith("HDMI plays no sound any more") and speaker.closed


def test_without_a_speaker_there_is_a_reason() -> None:
    def opener(name: str | None) -> Speaker:
        raise AudioError("there is no speaker here: plug one in, or go on without sound.")

    test = SpeakerTest(None, opener=opener)
    test._device._thread.join()
    assert test.error.startswith("there is no speaker here") and not test.is_playing
    test.begin_close()
    assert test.close()


@pytest.mark.parametrize("number", range(len(NOTES_HZ)))
def test_each_note_has_its_frequency_and_no_click(number: int) -> None:
    count = round(NOTE_S * SAMPLE_RATE)
    note = make_test_tone()[number * count :][:count].astype(np.float64)
    spectrum = np.abs(np.fft.rfft(note * np.hanning(count)))
    assert np.argmax(spectrum) * SAMPLE_RATE / count == pytest.approx(NOTES_HZ[number], abs=SAMPLE_RATE / count)
    assert note.max() == pytest.approx(AMPLITUDE, rel=0.01)
    assert abs(np.diff(note)).max() < AMPLITUDE * 2 * np.pi * NOTES_HZ[number] / SAMPLE_RATE * 1.02
    assert note[0] == 0 and abs(note[-1]) < 100
