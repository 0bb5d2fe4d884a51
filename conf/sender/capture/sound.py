"""Sound that is captured beside the frames: a clip's own track, a file in place of a microphone."""

from collections.abc import Generator
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from conf.audio.samples import SAMPLE_RATE, AudioBlock
from conf.errors import CameraError
from conf.sender.capture.clip import SOUND_RATE, Clip, open_clip, read_sound


class SoundSource(Protocol):
    """Where sound comes from."""

    def read(self, until: float, /) -> list[AudioBlock]:
        """Return the sound captured up to a time on the clock of the frames that was not returned yet."""
        ...

    def close(self) -> None:
        """Release the file or device."""
        ...


class FileSoundSource:
    """The sound of a file, as if captured while its frames are. With a looped clip both start again together."""

    def __init__(self, path: Path | str, *, clip: Clip | None = None, loop: bool = False) -> None:
        """Open a file with sound.

        clip : whose frames it accompanies, None for a file of its own, which starts when it is first read
        loop : a file of its own starts again at its end
        Raises CameraError if the file cannot be read or has no sound.
        """
        self._path = path
        self._clip = clip
        self._loop = loop and clip is None
        self._round = 0
        self._start, self._offset = (clip.round.start, clip.round.offset) if clip else (0.0, 0.0)
        self._has_started = clip is not None
        self._blocks = self._open()
        self._pending = next(self._blocks, None)
        if self._pending is None:
            raise CameraError(f"{path} has no sound: give a file with a sound track, or --no-sound.")

    def read(self, until: float, /) -> list[AudioBlock]:
        """Return the sound up to `until` that was not returned yet, in blocks without overlap."""
        if not self._has_started:
            self._start = self._offset = until
            self._has_started = True
        blocks: list[AudioBlock] = []
        while self._clip and self._clip.round.number != self._round and until >= self._clip.round.start:
            blocks += self._read_round(self._clip.round.start)
            self._round, self._start, self._offset = (
                self._clip.round.number, self._clip.round.start, self._clip.round.offset
            )  # fmt: skip
            self._reopen()
        blocks += self._read_round(until)
        while self._loop and self._pending is None and blocks:
            self._start = self._offset = blocks[-1].timestamp + len(blocks[-1].samples) / SAMPLE_RATE
            self._reopen()
            more = self._read_round(until)
            if not more:
                break
            blocks += more
        return blocks

    def close(self) -> None:
        """Close the file."""
        self._blocks.close()

    def _open(self) -> Generator[tuple[float, NDArray[np.int16]]]:
        return read_sound(self._path, rate=SAMPLE_RATE)

    def _reopen(self) -> None:
        self._blocks.close()
        self._blocks = self._open()
        self._pending = next(self._blocks, None)

    def _read_round(self, until: float) -> list[AudioBlock]:
        """Return the rest of the present round up to `until`, without what lies before the round's first frame."""
        blocks = []
        while self._pending is not None:
            timestamp, samples = self._pending[0] + self._offset, self._pending[1]
            due = round((until - timestamp) * SAMPLE_RATE)
            if due <= 0:
                break
            early = max(0, round((self._start - timestamp) * SAMPLE_RATE))
            if early < min(due, len(samples)):
                blocks.append(AudioBlock(timestamp + early / SAMPLE_RATE, samples[early:due]))
            if due < len(samples):
                self._pending = self._pending[0] + due / SAMPLE_RATE, samples[due:]
                break
            self._pending = next(self._blocks, None)
        return blocks


def record_sound(path: Path | str, /) -> NDArray[np.int16]:
    """Return a clip's whole sound from the time of its first frame on, (n,) mono at clip.SOUND_RATE.

    Raises CameraError if the file cannot be read or has no sound.
    """
    with open_clip(path) as clip:
        offset = clip.round.offset
    samples = np.zeros(0, np.int16)
    found = False
    for timestamp, block in read_sound(path, rate=SOUND_RATE):
        found = True
        position = round((timestamp + offset) * SOUND_RATE)
        if position > len(samples):
            samples = np.concatenate([samples, np.zeros(position - len(samples), np.int16)])
        samples = np.concatenate([samples, block[max(0, len(samples) - position) :]])
    if not found:
        raise CameraError(f"{path} has no sound: leave --sound out.")
    return samples
