"""The numbers of a photograph in few bytes: where its points lie, how the neutral pose differs, the person's outline.

Strategy. All faces are much alike, and what is unlike is alike for points that lie together. A point is told by how it
differs from the average face's, less what its parent differs: the points form a tree, learned beforehand like the
average itself, the control points first. The differences are whole steps, range-coded with the motion codec's tables;
for each there is a scale that says how far from zero it usually lies. Learned by tools/train_portrait.py.
"""

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec import LIVE
from conf.protocol.codec.model import load_models
from conf.protocol.codec.symbols import Coder, Reader, Tables, Writer

FACE_FILE = Path(str(files("conf"))) / "assets" / "portrait.npz"
POINT_STEP = 0.02  # cm: a fifth of a per cent of the eye distance
OUTLINE_STEPS = 255  # from one border of the picture to the other
_CORNER_SPREAD = 28  # the scale of what lies between two corners: nine steps

Steps = NDArray[np.int64]


@dataclass(frozen=True)
class FaceModel:
    """What is known of faces beforehand, D points of which the first n are the control points.

    mean : (D, 3) int64, the average face, steps of POINT_STEP
    order : (D,) the points as they are told, the control points first
    parents : (D,) where in `order` the parent of each stands, -1 for the first
    spread : (D, 3) scale of each difference, in that order
    stir_spread : (n, 3) scale of what the neutral pose differs from the photographed one, point by point
    """

    mean: Steps
    order: Steps
    parents: Steps
    spread: Steps
    stir_spread: Steps

    @property
    def point_count(self) -> int:
        """The number D of points."""
        return len(self.mean)

    @property
    def control_count(self) -> int:
        """The number n of control points."""
        return len(self.stir_spread)

    def save(self, path: Path) -> None:
        """Write the file."""
        small = {name: getattr(self, name).astype(np.int16) for name in self.__dataclass_fields__}
        np.savez(path, **small)

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read the file."""
        with np.load(path) as arrays:
            return cls(**{name: arrays[name].astype(np.int64) for name in cls.__dataclass_fields__})


@cache
def load_face_model() -> FaceModel:
    """Return the shipped model."""
    return FaceModel.load(FACE_FILE)


def encode_shape(points: Steps, neutral: Steps, outline: Steps, model: FaceModel, /) -> bytes:
    """Return the bytes of a photograph's numbers.

    points (D, 3), neutral (n, 3) : steps of POINT_STEP; outline (K, 2) : steps of 1 / OUTLINE_STEPS
    """
    writer = Writer(trade=0)
    _code_shape(writer, model, (points, neutral, outline))
    return writer.finish()


def decode_shape(data: bytes, corners: int, model: FaceModel, /) -> tuple[Steps, Steps, Steps]:
    """Return points, neutral pose and outline of `corners` corners. Raises ProtocolError."""
    reader = Reader(data)
    nothing = np.zeros_like(model.mean), np.zeros((model.control_count, 3), np.int64), np.zeros((corners, 2), np.int64)
    found = _code_shape(reader, model, nothing)
    reader.finish()
    return found


def encode_neutral_shape(neutral: Steps, model: FaceModel, /) -> bytes:
    """Return the bytes of a neutral pose (n, 3), steps of POINT_STEP."""
    writer = Writer(trade=0)
    _code_face(writer, model, neutral)
    return writer.finish()


def decode_neutral_shape(data: bytes, model: FaceModel, /) -> Steps:
    """Return the neutral pose (n, 3). Raises ProtocolError."""
    reader = Reader(data)
    neutral = _code_face(reader, model, np.zeros((model.control_count, 3), np.int64))
    reader.finish()
    return neutral


def _code_shape(coder: Coder, model: FaceModel, wanted: tuple[Steps, Steps, Steps]) -> tuple[Steps, Steps, Steps]:
    tables = load_models()[LIVE.name].tables
    points, neutral, outline = wanted
    told = _code_face(coder, model, points)
    controls = told[: model.control_count]
    stir = _code_numbers(coder, tables, model.stir_spread, neutral - controls)
    sides = np.diff(outline, axis=0, prepend=0)
    told_sides = _code_numbers(coder, tables, np.full_like(sides, _CORNER_SPREAD), sides)
    return told, controls + stir, np.cumsum(told_sides, axis=0)


def _code_face(coder: Coder, model: FaceModel, wanted: Steps) -> Steps:
    """Code a whole face (D, 3), or the control points of one (n, 3)."""
    tables = load_models()[LIVE.name].tables
    count = len(wanted)
    wanted_off = (wanted - model.mean[:count]).tolist()
    off: list[list[int]] = []  # in the order they are told
    steps = zip(model.order[:count].tolist(), model.parents.tolist(), model.spread.tolist(), strict=False)
    for point, parent, spread in steps:
        base = off[parent] if parent >= 0 else [0, 0, 0]
        wants = zip(base, spread, wanted_off[point], strict=True)
        off.append([near + coder.number(tables, scale, want - near) for near, scale, want in wants])
    result = model.mean[:count].copy()
    result[model.order[:count]] += np.array(off)
    return result


def _code_numbers(coder: Coder, tables: Tables, spread: Steps, wanted: Steps) -> Steps:
    pairs = zip(spread.ravel().tolist(), wanted.ravel().tolist(), strict=True)
    numbers = [coder.number(tables, scale, want) for scale, want in pairs]
    return np.array(numbers, np.int64).reshape(wanted.shape)
