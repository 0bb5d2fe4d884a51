"""Mix several talkers into one sound and name the loudest."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from conf.audio.samples import FULL_SCALE, SAMPLE_RATE, Samples, level_dbfs, to_int16

Talker = TypeVar("Talker")

_KNEE = 0.7 * FULL_SCALE  # below it the mix is exact; above, it bends towards full scale
_SMOOTHING_S = 0.3  # time constant of a talker's level
_AUDIBLE_DBFS = -50.0  # who is quieter is nobody's loudest
_LEAD_DB = 3.0  # another talker must be so much louder to become the loudest


@dataclass(frozen=True)
class MixedSound(Generic[Talker]):
    """A block of all talkers together. loudest : who speaks, None if all are silent"""

    samples: Samples
    loudest: Talker | None


class Mixer(Generic[Talker]):
    """The mixer of one loudspeaker."""

    def __init__(self) -> None:
        self._levels: dict[Talker, float] = {}
        self._loudest: Talker | None = None

    def mix(self, blocks: Mapping[Talker, Samples], /) -> MixedSound[Talker]:
        """Add blocks of one length, one for each talker of the moment; talkers without a block are forgotten."""
        lengths = {len(block) for block in blocks.values()}
        if len(lengths) > 1:
            raise ValueError("blocks must have one length")
        count = lengths.pop() if lengths else 0
        self._levels = {talker: self._level(talker, block) for talker, block in blocks.items()}
        self._choose_loudest()
        if len(blocks) == 1:
            [block] = blocks.values()
            if max(block.max(initial=0), -int(block.min(initial=0))) <= _KNEE:
                return MixedSound(block, self._loudest)  # as it is, which most calls are
        total = np.zeros(count)
        for block in blocks.values():
            total += block
        return MixedSound(to_int16(soft_limit(total)), self._loudest)

    def _level(self, talker: Talker, block: Samples) -> float:
        """Return a talker's level, dBFS: smoothed over some syllables."""
        new = level_dbfs(block)
        old = self._levels.get(talker, new)
        weight = 1 - math.exp(-len(block) / SAMPLE_RATE / _SMOOTHING_S)
        return old + (new - old) * weight

    def _choose_loudest(self) -> None:
        levels = {talker: level for talker, level in self._levels.items() if level > _AUDIBLE_DBFS}
        best = max(levels, key=lambda talker: levels[talker], default=None)
        current = levels.get(self._loudest) if self._loudest is not None else None
        if best is None or current is None or levels[best] > current + _LEAD_DB:
            self._loudest = best


def soft_limit(values: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Bend what is beyond the knee so that no sum exceeds full scale; below the knee nothing changes."""
    room = FULL_SCALE - 1 - _KNEE
    excess = np.maximum(0.0, np.abs(values) - _KNEE)
    if not excess.any():
        return values
    return np.asarray(np.sign(values) * (np.minimum(np.abs(values), _KNEE) + room * np.tanh(excess / room)))
