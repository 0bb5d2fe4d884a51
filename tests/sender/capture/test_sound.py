"""Sound beside frames: read up to a time, in step with a clip through its rounds, and from a file of its own."""

import wave
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from conf.audio.samples import SAMPLE_RATE, AudioBlock
from conf.errors import CameraError
from conf.sender.capture.clip import open_clip
from conf.sender.capture.sound import FileSoundSource, record_sound
from tests.support.generated_clips import write_clip

TIMES = [i / 25 for i in range(25)]


def write_ramp(path: Path, count: int) -> Path:
    """Write a WAV file at SAMPLE_RATE whose samples are 0, 1, 2 ..."""
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(SAMPLE_RATE)
        file.writeframes(np.arange(count, dtype="<i2").tobytes())
    return path


def samples_of(blocks: list[AudioBlock]) -> list[int]:
    return [int(sample) for block in blocks for sample in block.samples]


def check_contiguous(blocks: list[AudioBlock]) -> None:
    for block, following in pairwise(blocks):
        assert following.timestamp == pytest.approx(block.timestamp + len(block.samples) / SAMPLE_RATE, abs=1e-4)


def test_sound_is_returned_once_up_to_the_time_asked_for(tmp_path: Path) -> None:
    sound = FileSoundSource(write_ramp(tmp_path / "ramp.wav", 5000))
    assert sound.read(50.0) == []  # here it starts
    blocks = sound.read(50.01)
    assert samples_of(blocks) == list(range(160)) and blocks[0].timestamp == 50.0
    assert sound.read(50.01) == []
    rest = sound.read(60.0)
    assert samples_of(rest) == list(range(160, 5000)) and rest[0].timestamp == pytest.approx(50.01)
    assert sound.read(70.0) == []
    sound.close()


def test_a_file_that_loops_goes_on_without_a_gap(tmp_path: Path) -> None:
    sound = FileSoundSource(write_ramp(tmp_path / "ramp.wav", 1000), loop=True)
    sound.read(0.0)
    blocks = [block for at in np.arange(0.01, 0.2, 0.01) for block in sound.read(float(at))]
    assert samples_of(blocks) == [i % 1000 for i in range(round(0.19 * SAMPLE_RATE))]
    check_contiguous(blocks)


@pytest.mark.slow
def test_the_sound_of_a_looped_clip_starts_again_with_its_frames(tmp_path: Path) -> None:
    path = write_clip(tmp_path / "tone.mp4", TIMES, sound_seconds=1.3)  # 0.3 s longer than the picture
    with open_clip(path, loop=True) as clip:
        sound = FileSoundSource(path, clip=clip)
        blocks: list[AudioBlock] = []
        for _ in range(60):
            frame = clip.read()
            assert frame is not None
            blocks += sound.read(frame.timestamp)
        check_contiguous(blocks)
        assert clip.round.number == 2 and clip.round.start == pytest.approx(2.0, abs=0.01)
        samples = np.concatenate([block.samples for block in blocks])
        assert len(samples) == pytest.approx(59 / 25 * SAMPLE_RATE, abs=2)
        first, second = samples[3200:12000], samples[3200 + SAMPLE_RATE : 12000 + SAMPLE_RATE]
        assert np.abs(first - second.astype(float)).max() < 300  # the same sound one round later, but for coding
        sound.close()


def test_files_without_sound_are_refused(tmp_path: Path) -> None:
    path = write_clip(tmp_path / "silent.mp4", TIMES[:3])
    with pytest.raises(CameraError, match=r"silent\.mp4 has no sound: give a file with a sound track, or --no-sound\."):
        FileSoundSource(path)
    with pytest.raises(CameraError, match="there is no file"):
        FileSoundSource(tmp_path / "nothing.wav")


@pytest.mark.slow
def test_a_whole_sound_track_begins_with_the_first_frame(tmp_path: Path) -> None:
    samples = record_sound(write_clip(tmp_path / "tone.mp4", TIMES, sound_seconds=1.0))
    assert len(samples) == pytest.approx(48000, abs=1100)
    spectrum = np.abs(np.fft.rfft(samples[12000:36000]))
    assert spectrum.argmax() * 2 == pytest.approx(440, abs=2)
    with pytest.raises(CameraError, match=r"silent\.mp4 has no sound: leave --sound out\."):
        record_sound(write_clip(tmp_path / "silent.mp4", TIMES[:3]))
