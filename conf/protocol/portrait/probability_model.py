"""The trained statistics of portraits: mean face shape, and the probabilities of differences and coefficients.

Strategy. All faces are similar, and deviations from the mean are similar for nearby points. So the points form a
trained tree: of each point its deviation from the mean is coded less that of its parent. The differences are integers
in steps, range-coded with the tables of the motion codec; each has a trained scale, its expected distance from zero.
Trained by tools/train/portrait.py.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from itertools import accumulate
from typing import IO, Any, Self

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec.model import load_models
from conf.protocol.codec.profiles import LIVE
from conf.protocol.codec.range_coder import TOTAL
from conf.protocol.codec.symbol_coder import SymbolCoder, Tables

MODEL_FILE = files("conf") / "assets" / "portrait.npz"
REGIONS = ("mouth", "eyes")  # of patches, in the order of their numbers
# Arrays of the file, in the order of the fields.
TREE_ARRAYS = ("mean", "order", "parents", "spread")
BLOCK_ARRAYS = ("coded", "last", "level_spread")

Steps = NDArray[np.int64]
Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class PointTree:
    """The statistics of D points with d coordinates.

    mean : (D, d) int64, steps
    order : (D,) the points in coding order
    parents : (D,) index in `order` of each point's parent, -1 for none
    scale : (D, d) scale of each difference, in coding order
    """

    mean: Steps
    order: Steps
    parents: Steps
    scale: Steps

    def code(self, coder: SymbolCoder, points: Steps) -> Steps:
        """Code the points (c, d) and return them: all D, or the first c if these come first in coding order."""
        tables, count = difference_tables(), len(points)
        targets = (points - self.mean[:count]).tolist()
        no_deviation = [0] * self.mean.shape[1]
        deviations: list[list[int]] = []  # in coding order
        steps = zip(self.order[:count].tolist(), self.parents.tolist(), self.scale.tolist(), strict=False)
        for point, parent, scales in steps:
            base = deviations[parent] if parent >= 0 else no_deviation
            axes = zip(base, scales, targets[point], strict=True)
            deviations.append([b + coder.number(tables, scale, target - b) for b, scale, target in axes])
        result = self.mean[:count].copy()
        result[self.order[:count]] += np.array(deviations)
        return result


@dataclass(frozen=True)
class RegionModel:
    """A region of patches. points : of a patch; descriptor_scale : (k,) scale of each number of its descriptor"""

    points: PointTree
    descriptor_scale: Steps


@dataclass(frozen=True)
class BlockModel:
    """The statistics of 8 x 8 blocks, of brightness (0) and of chroma (1).

    coded : (2, 3) probability in 2^-15 that a block is not empty, by how many of its left and upper neighbours are not
    last : (2, 64) frequencies of the index of the last coefficient, sum 2^15
    coefficient_scale : (2, 64) scale of each coefficient
    """

    coded: Steps
    last: Steps
    coefficient_scale: Steps

    def tables(self) -> tuple[list[list[list[int]]], list[list[int]], list[list[int]]]:
        """Return the cumulative frequencies of `coded` and `last`, and the scales, as lists."""
        coded = [[[0, TOTAL - probability, TOTAL] for probability in row] for row in self.coded.tolist()]
        return coded, [[0, *accumulate(row)] for row in self.last.tolist()], self.coefficient_scale.tolist()


@dataclass(frozen=True)
class PortraitModel:
    """All statistics of the file.

    face : the D points of a photo, the n control points first
    neutral_difference_scale : (n, 3) scale of the neutral pose less the photo's pose
    regions : of patches, by number
    blocks : of patches
    """

    face: PointTree
    neutral_difference_scale: Steps
    regions: Sequence[RegionModel]
    blocks: BlockModel

    @classmethod
    def load(cls, file: IO[bytes]) -> Self:
        """Read the file."""
        with np.load(file) as stored:
            arrays = {name: stored[name].astype(np.int64) for name in stored.files}
        face, *trees = (PointTree(*(arrays[f"{name}_{key}"] for key in TREE_ARRAYS)) for name in ("face", *REGIONS))
        scales = (arrays[f"{name}_key_spread"] for name in REGIONS)
        regions = [RegionModel(tree, scale) for tree, scale in zip(trees, scales, strict=True)]
        return cls(face, arrays["stir_spread"], regions, BlockModel(*(arrays[key] for key in BLOCK_ARRAYS)))


@cache
def load_portrait_model() -> PortraitModel:
    """Return the shipped model."""
    with MODEL_FILE.open("rb") as file:
        return PortraitModel.load(file)


def difference_tables() -> Tables:
    """Return the tables of differences: those of the live profile of the motion codec."""
    return load_models()[LIVE.name].tables


def code_numbers(coder: SymbolCoder, scale: Steps, targets: Steps) -> Steps:
    """Code integers, each at its scale; both arrays have the same shape."""
    tables = difference_tables()
    pairs = zip(scale.ravel().tolist(), targets.ravel().tolist(), strict=True)
    return np.array([coder.number(tables, scale, target) for scale, target in pairs], np.int64).reshape(targets.shape)
