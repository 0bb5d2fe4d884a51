"""The trained file: transform, contexts and tables of each profile.

Everything that steers the range coder is a whole number here: two machines must agree on every bit of it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from operator import mul
from typing import Any

import numpy as np

from conf.protocol.codec.profiles import PROFILES, Profile
from conf.protocol.codec.quantised_frame import QuantisedFrame
from conf.protocol.codec.symbol_coder import SCALES_PER_OCTAVE, Tables
from conf.protocol.codec.transform import MotionTransform

FILE = "codec.npz"
WEIGHT_ONE = 256  # a context weight of 1
MAX_AGE = 63  # ticks between a frame and its reference
RAW_OCTAVES = 8  # scales beyond the last table: low bits sent as they are


@dataclass(frozen=True)
class CodecModel:
    """What coding one profile needs.

    standing : the frame that stands in for a reference when there is none
    rows : for each age 0 (none) to MAX_AGE the row of `weights`
    companion_rows : the same when the frame before the reference is known too
    weights : [row][value][feature] context weights, WEIGHT_ONE is 1: features give the scale of a value
    growth : how many 65536ths of itself the middle recedes when log scale grows by one step
    """

    profile: Profile
    transform: MotionTransform
    tables: Tables
    default_reference: QuantisedFrame
    rows: tuple[int, ...]
    second_reference_rows: tuple[int, ...]
    weights: list[list[list[int]]]
    scale_coupling: int
    points: int

    def scale(self, row: int, index: int, features: tuple[int, ...]) -> int:
        """Return how far from its prediction value `index` will lie: an index on the scale grid."""
        scale: int = sum(map(mul, self.weights[row][index], features)) // WEIGHT_ONE
        return max(0, min(self.tables.last + RAW_OCTAVES * SCALES_PER_OCTAVE, scale))


@cache
def load_models() -> dict[str, CodecModel]:
    """Return the shipped model of each profile, by name."""
    with resources.files("conf.assets").joinpath(FILE).open("rb") as file, np.load(file) as arrays:
        return build_models({name: arrays[name] for name in arrays.files})


def build_models(arrays: Mapping[str, np.ndarray[Any, Any]]) -> dict[str, CodecModel]:
    """Build the models from the file's arrays: tools/train/codec.py says what each is."""
    return {name: _build_model(profile, arrays) for name, profile in PROFILES.items()}


def _build_model(profile: Profile, arrays: Mapping[str, np.ndarray[Any, Any]]) -> CodecModel:
    transform = build_transform(profile, arrays)
    ages = arrays["ages"].tolist()
    rows = tuple(_row(age, ages) for age in range(MAX_AGE + 1))
    return CodecModel(
        profile=profile,
        transform=transform,
        tables=Tables.from_frequencies(arrays[f"{profile.name}_frequencies"].tolist()),
        default_reference=QuantisedFrame(tuple(arrays[f"{profile.name}_standing"].tolist())),
        rows=rows,
        second_reference_rows=tuple(row and row + len(ages) for row in rows),
        weights=arrays[f"{profile.name}_weights"].tolist(),
        scale_coupling=int(arrays[f"{profile.name}_growth"]),
        points=len(arrays["correction"]),
    )


def build_transform(profile: Profile, arrays: Mapping[str, np.ndarray[Any, Any]]) -> MotionTransform:
    """Return the transform of a profile, from the file's arrays."""
    step = profile.step
    basis = arrays["basis"].astype(np.float64)  # (3 n, K) orthonormal
    weight = arrays["weight"].astype(np.float64).reshape(-1)  # (3 n,) eye distances for one FAPU unit, over sqrt(n)
    return MotionTransform(
        forward_matrix=weight[:, None] * basis / step,
        inverse_matrix=step * basis.T / weight,
        pose_steps=step * arrays["pose_unit"].astype(np.float64),
        face_centre=arrays["middle"].astype(np.float64),
        typical_log_scale=float(arrays["usual_log_scale"]),
        residual_steps=arrays["correction"].astype(np.float64),
        coupling=arrays["coupling"].astype(np.float64),
        stagger=arrays["stagger"].astype(np.float64),
        reconstruction_shift=arrays[f"{profile.name}_lean"].astype(np.float64),
    )


def _row(age: int, ages: list[int]) -> int:
    """Return the row trained for the nearest age, in proportion; row 0 is for no reference."""
    if age == 0:
        return 0
    return 1 + min(range(len(ages)), key=lambda i: max(age / ages[i], ages[i] / age))
