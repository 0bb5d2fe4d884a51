"""The trained file: transform, context weights and tables of each profile.

Everything that steers the range coder is an integer, because two machines must agree on every bit of it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from operator import mul
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec.expression_curves import STRENGTH, keep_curves, load_curves
from conf.protocol.codec.lip_opening import LipOpening
from conf.protocol.codec.mouth_width import MouthWidth
from conf.protocol.codec.profiles import PROFILES, Profile
from conf.protocol.codec.reconstruction import Reconstruction
from conf.protocol.codec.reference_frames import MAX_AGE, QuantisedFrame
from conf.protocol.codec.symbol_coder import SCALES_PER_OCTAVE, Tables
from conf.protocol.codec.transform import MotionTransform

FILE = "codec.npz"
WEIGHT_ONE = 256  # a context weight of 1
RAW_OCTAVES = 8  # octaves of scale above the last table, coded with raw low bits

Arrays = Mapping[str, np.ndarray[Any, Any]]


@dataclass(frozen=True)
class CodecModel:
    """What coding one profile needs.

    default_reference : used when there is no reference
    rows : row of `weights` for each age 0 (no reference) to MAX_AGE
    second_reference_rows : the same with a second reference
    weights : [row][value][feature] context weights in units of 1 / WEIGHT_ONE
    scale_coupling : 65536ths by which the face centre, in face sizes, shrinks per step of log scale
    lip_opening, mouth_width : measure the mouth, for encoders; no width where a payload holds several frames, which
        correcting one of them would code again
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
    lip_opening: LipOpening
    mouth_width: MouthWidth | None

    def scale(self, row: int, index: int, features: tuple[int, ...]) -> int:
        """Return the expected distance of value `index` from its prediction, as an index on the scale grid."""
        scale: int = sum(map(mul, self.weights[row][index], features)) // WEIGHT_ONE
        return 0 if scale < 0 else min(scale, self.tables.last + RAW_OCTAVES * SCALES_PER_OCTAVE)


@cache
def load_models() -> dict[str, CodecModel]:
    """Return the shipped model of each profile, by name."""
    with resources.files("conf.assets").joinpath(FILE).open("rb") as file, np.load(file) as arrays:
        return build_models({name: arrays[name] for name in arrays.files}, load_curves())


def build_models(arrays: Arrays, curves: NDArray[np.float64] | None = None, /) -> dict[str, CodecModel]:
    """Build the models from the file's arrays, which WIRE.md describes.

    curves : (R, 3 n) gradients of the curves that encoders keep, see expression_curves.py; None for none. Profiles with
        several frames in a payload keep none: the narrowest have no bits for what it costs when motion is unusual
    """
    return {name: _build_model(profile, arrays, curves) for name, profile in PROFILES.items()}


def _build_model(profile: Profile, arrays: Arrays, curves: NDArray[np.float64] | None) -> CodecModel:
    ages = arrays["ages"].tolist()
    rows = tuple(_row(age, ages) for age in range(MAX_AGE + 1))
    transform = _build_transform(profile, arrays, curves if profile.frames_per_datagram == 1 else None)
    return CodecModel(
        profile=profile,
        transform=transform,
        tables=Tables.from_frequencies(arrays[f"{profile.tables}_frequencies"].tolist()),
        default_reference=QuantisedFrame(tuple(arrays[f"{profile.tables}_standing"].tolist())),
        rows=rows,
        second_reference_rows=tuple(row and row + len(ages) for row in rows),
        weights=arrays[f"{profile.tables}_weights"].tolist(),
        scale_coupling=int(arrays[f"{profile.tables}_growth"]),
        points=len(arrays["correction"]),
        lip_opening=LipOpening.build(arrays["opening"].astype(np.float64), transform, step=profile.step),
        mouth_width=MouthWidth.build(transform, step=profile.step) if profile.frames_per_datagram == 1 else None,
    )


def _build_transform(profile: Profile, arrays: Arrays, curves: NDArray[np.float64] | None) -> MotionTransform:
    step = profile.step
    forward, inverse = arrays["analysis"].astype(np.float64) / step, step * arrays["synthesis"].astype(np.float64)
    return MotionTransform(
        forward_matrix=forward if curves is None else keep_curves(forward, inverse, curves, strength=STRENGTH),
        inverse_matrix=inverse,
        pose_steps=step * arrays["pose_unit"].astype(np.float64),
        face_centre=arrays["middle"].astype(np.float64),
        typical_log_scale=float(arrays["usual_log_scale"]),
        residual_steps=arrays["correction"].astype(np.float64),
        coupling=arrays["coupling"].astype(np.float64),
        stagger=arrays["stagger"].astype(np.float64),
        reconstruction=Reconstruction(
            previous=arrays[f"{profile.tables}_lean"].astype(np.float64),
            history=arrays[f"{profile.tables}_history"].astype(np.float64),
        ),
    )


def _row(age: int, ages: list[int]) -> int:
    """Return the row of the trained age with the nearest ratio to `age`; row 0 is for no reference."""
    if age == 0:
        return 0
    return 1 + min(range(len(ages)), key=lambda i: max(age / ages[i], ages[i] / age))
