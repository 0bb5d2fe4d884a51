"""WAV files are written whole, and read again by anything."""

import wave
from pathlib import Path

import numpy as np
import pytest

from conf.errors import RecordingError
from conf.output.wav_writer import write_wav


def test_samples_are_written_as_they_are(tmp_path: Path) -> None:
    samples = np.array([0, 1, -1, 32767, -32768], np.int16)
    write_wav(tmp_path / "a.wav", samples, rate=16000)
    with wave.open(str(tmp_path / "a.wav"), "rb") as file:
        assert (file.getnchannels(), file.getsampwidth(), file.getframerate()) == (1, 2, 16000)
        assert np.frombuffer(file.readframes(10), "<i2").tolist() == samples.tolist()


def test_a_folder_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"a\.wav cannot be written"):
        write_wav(tmp_path / "nothing" / "a.wav", np.zeros(1, np.int16))
