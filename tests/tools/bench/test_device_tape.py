"""What devices gave is kept with its times, survives a file, and is replayed as it was read."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from conf.audio.devices import _ClockedBuffer
from conf.audio.drift import PLAYED_DROPOUT_S
from tests.support.synthetic_voice import tone
from tools.bench.device_tape import DeviceTape, Read


def give(tape: DeviceTape) -> list[Read]:
    """Let two devices run for 0.2 s with late callbacks; return what a program read."""
    buffers = _ClockedBuffer(), _ClockedBuffer(dropout_s=PLAYED_DROPOUT_S)
    tape.attach(SimpleNamespace(_captured=buffers[0]), SimpleNamespace(_played=buffers[1]))  # type: ignore[arg-type]
    sound, rng, reads = tone(300, 0.6), np.random.default_rng(1), []
    for index in range(20):
        at = 5.0 + 0.01 * index
        for buffer in buffers:
            buffer.write(sound[480 * index : 480 * (index + 1)], at + rng.uniform(0, 0.004))
        tape.reads.append(at + 0.005)
        reads.append((buffers[0].read(), buffers[1].read()))
    return reads


def test_a_tape_gives_again_what_was_read(tmp_path: Path) -> None:
    tape = DeviceTape()
    reads = give(tape)
    tape.save(tmp_path / "tape.npz")
    for again in (tape, DeviceTape.load(tmp_path / "tape.npz")):
        replayed = list(again.replay())
        assert len(replayed) == 20
        for blocks, expected in zip(replayed, reads, strict=True):
            for block, other in zip(blocks, expected, strict=True):
                assert block is not None and other is not None
                np.testing.assert_array_equal(block.samples, other.samples)
                assert block.timestamp == pytest.approx(other.timestamp)
