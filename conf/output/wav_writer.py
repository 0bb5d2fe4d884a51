"""Write sound as a WAV file."""

import wave
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.atomic_write import atomic_write, report_write_errors
from conf.errors import RecordingError


def write_wav(path: Path, samples: NDArray[np.int16], /, *, rate: int = 48000) -> None:
    """Write (n,) mono samples at `rate` a second, whole or not at all. Raises RecordingError."""
    with report_write_errors(path, RecordingError), atomic_write(path) as partial, partial.open("wb") as file:
        writer = wave.open(file, "wb")
        writer.setnchannels(1)
        writer.setsampwidth(2)
        writer.setframerate(rate)
        writer.writeframes(samples.astype("<i2").tobytes())
        writer.close()
