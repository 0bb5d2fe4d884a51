"""Keep what the callbacks of a microphone and a speaker gave, with their times, and replay it without devices.

What an echo canceller makes of late callbacks, dropouts and steps of a device's latency can so be computed again, in
any version of the program, on the same sound.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from conf.audio.devices import Microphone, Speaker, _ClockedBuffer
from conf.audio.drift import PLAYED_DROPOUT_S
from conf.audio.samples import AudioBlock, Samples

Callback = tuple[float, Samples]  # its time, s, and the samples of DEVICE_RATE
Read = tuple[AudioBlock | None, AudioBlock | None]  # captured, played


@dataclass
class DeviceTape:
    """The callbacks of both devices, and the times at which the program read from them."""

    captured: list[Callback] = field(default_factory=list)
    played: list[Callback] = field(default_factory=list)
    reads: list[float] = field(default_factory=list)

    def attach(self, microphone: Microphone, speaker: Speaker) -> None:
        """Keep what comes from two open devices from now on."""
        for buffer, callbacks in ((microphone._captured, self.captured), (speaker._played, self.played)):
            buffer.write = _keeping(buffer, callbacks)  # type: ignore[method-assign, assignment]

    def replay(self) -> Iterator[Read]:
        """Yield what each read returned."""
        buffers = _ClockedBuffer(), _ClockedBuffer(dropout_s=PLAYED_DROPOUT_S)
        waiting = [list(reversed(callbacks)) for callbacks in (self.captured, self.played)]
        for at in self.reads:
            for buffer, callbacks in zip(buffers, waiting, strict=True):
                while callbacks and callbacks[-1][0] <= at:
                    end, samples = callbacks.pop()
                    buffer.write(samples, end)
            yield buffers[0].read(), buffers[1].read()

    def save(self, path: Path) -> None:
        """Write a NumPy archive."""
        np.savez_compressed(
            path,
            reads=np.array(self.reads),
            captured_at=np.array([at for at, _ in self.captured]),
            captured_counts=np.array([len(samples) for _, samples in self.captured]),
            captured_samples=_joined(self.captured),
            played_at=np.array([at for at, _ in self.played]),
            played_counts=np.array([len(samples) for _, samples in self.played]),
            played_samples=_joined(self.played),
        )

    @classmethod
    def load(cls, path: Path) -> "DeviceTape":
        """Read a file that `save` wrote."""
        with np.load(path) as arrays:
            tracks = [
                np.split(arrays[f"{name}_samples"], np.cumsum(arrays[f"{name}_counts"])[:-1])
                for name in ("captured", "played")
            ]
            times = [arrays[f"{name}_at"].tolist() for name in ("captured", "played")]
            captured, played = (list(zip(*pair, strict=True)) for pair in zip(times, tracks, strict=True))
            return cls(captured, played, arrays["reads"].tolist())


def _keeping(buffer: _ClockedBuffer, callbacks: list[Callback]) -> Callable[[Samples, float], None]:
    write = buffer.write

    def keep(samples: Samples, end: float) -> None:
        callbacks.append((end, samples.copy()))
        write(samples, end)

    return keep


def _joined(callbacks: list[Callback]) -> Samples:
    return np.concatenate([np.zeros(0, np.int16), *(samples for _, samples in callbacks)])
