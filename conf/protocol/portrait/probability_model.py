"""What both sides know of portraits beforehand: how faces usually lie, and which numbers are likely in a patch.

Strategy. All faces are much alike, and what is unlike is alike for points that lie together. A point is told by how it
differs from the average, less what its parent differs: the points form a tree, learned beforehand like the average
itself. The differences are whole steps, range-coded with the motion codec's tables; for each there is a scale that says
how far from zero it usually lies. Learned by tools/train/portrait.py.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from itertools import accumulate
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec import LIVE
from conf.protocol.codec.model import load_models
from conf.protocol.codec.symbol_coder import SymbolCoder, Tables

MODEL_FILE = Path(str(files("conf"))) / "assets" / "portrait.npz"
REGIONS = ("mouth", "eyes")  # that patches show, in the order of their numbers
TREE = {"mean": "mean", "order": "order", "parents": "parents", "spread": "scale"}  # array of the file -> field
BLOCKS = {"coded": "coded", "last": "last", "level_spread": "coefficient_scale"}

Steps = NDArray[np.int64]
Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class PointTree:
    """How D points of d coordinates usually lie.

    mean : (D, d) int64 steps, the average
    order : (D,) the points as they are told
    parents : (D,) where in `order` the parent of each stands, -1 for the first
    spread : (D, d) scale of each difference, in that order
    """

    mean: Steps
    order: Steps
    parents: Steps
    scale: Steps

    def code(self, coder: SymbolCoder, values: Steps) -> Steps:
        """Code the points (c, d), all of them or the first c, if those are told before the others."""
        tables, count = difference_tables(), len(values)
        wanted_off = (values - self.mean[:count]).tolist()
        nothing = [0] * self.mean.shape[1]
        off: list[list[int]] = []  # in the order they are told
        steps = zip(self.order[:count].tolist(), self.parents.tolist(), self.scale.tolist(), strict=False)
        for point, parent, spread in steps:
            base = off[parent] if parent >= 0 else nothing
            wants = zip(base, spread, wanted_off[point], strict=True)
            off.append([near + coder.number(tables, scale, want - near) for near, scale, want in wants])
        result = self.mean[:count].copy()
        result[self.order[:count]] += np.array(off)
        return result


@dataclass(frozen=True)
class RegionModel:
    """A region that patches show. points : of a patch; key_spread : (k,) scale of each key."""

    points: PointTree
    descriptor_scale: Steps


@dataclass(frozen=True)
class BlockModel:
    """Blocks of 64 coefficients, of brightness (0) and of tint (1).

    coded : (2, 3) of 2^15, how likely a block is not empty when none, one or both of those left of it and above are not
    last : (2, 64) frequencies of the last coefficient that is told, adding up to 2^15
    level_spread : (2, 64) scale of each coefficient
    """

    coded: Steps
    last: Steps
    coefficient_scale: Steps

    def tables(self) -> tuple[list[list[list[int]]], list[list[int]], list[list[int]]]:
        """Return cumulative frequencies of coded and last, and the scales, as lists."""
        whole = sum(self.last[0].tolist())
        coded = [[[0, whole - chance, whole] for chance in row] for row in self.coded.tolist()]
        return coded, [[0, *accumulate(row)] for row in self.last.tolist()], self.coefficient_scale.tolist()


@dataclass(frozen=True)
class PortraitModel:
    """Everything that was learned.

    face : the D points of a photograph, the n control points first
    stir_spread : (n, 3) scale of what the neutral pose differs from the photographed one, point by point
    regions : those of patches, by number
    blocks : of the pictures of patches
    """

    face: PointTree
    neutral_difference_scale: Steps
    regions: Sequence[RegionModel]
    blocks: BlockModel

    def save(self, path: Path) -> None:
        """Write the file."""
        arrays: Arrays = {"stir_spread": self.neutral_difference_scale}
        arrays |= {f"face_{key}": getattr(self.face, field) for key, field in TREE.items()}
        for name, region in zip(REGIONS, self.regions, strict=True):
            arrays |= {f"{name}_{key}": getattr(region.points, field) for key, field in TREE.items()}
            arrays[f"{name}_key_spread"] = region.descriptor_scale
        arrays |= {key: getattr(self.blocks, field) for key, field in BLOCKS.items()}
        small: dict[str, Any] = {name: array.astype(np.int16) for name, array in arrays.items()}
        np.savez(path, **small)

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read the file."""
        with np.load(path) as file:
            arrays = {name: file[name].astype(np.int64) for name in file.files}
        regions = [RegionModel(_point_tree(arrays, name), arrays[f"{name}_key_spread"]) for name in REGIONS]
        blocks = BlockModel(*(arrays[name] for name in BLOCKS))
        return cls(_point_tree(arrays, "face"), arrays["stir_spread"], regions, blocks)


def _point_tree(arrays: Arrays, name: str) -> PointTree:
    return PointTree(*(arrays[f"{name}_{part}"] for part in TREE))


@cache
def load_portrait_model() -> PortraitModel:
    """Return the shipped model."""
    return PortraitModel.load(MODEL_FILE)


def difference_tables() -> Tables:
    """Return the tables of differences: those of live motion."""
    return load_models()[LIVE.name].tables


def code_numbers(coder: SymbolCoder, scale: Steps, values: Steps) -> Steps:
    """Code numbers, each at its scale; both of the same shape."""
    tables = difference_tables()
    pairs = zip(scale.ravel().tolist(), values.ravel().tolist(), strict=True)
    return np.array([coder.number(tables, scale, want) for scale, want in pairs], np.int64).reshape(values.shape)
