"""FAP files: MPEG-4 facial animation parameters as text, for other players.

A file of version 2.1 has a line `2.1 NAME FPS FRAMES`, then two lines for each frame: a mask of 68 zeros and ones, and
the frame number followed by the values of the parameters in the mask. Parameters 1 and 2, viseme and expression, are
not written.
Source: ISO/IEC 14496-2, table C.1 (parameters, units, directions); the loaders of Xface (FapFile.cpp, 2004-2008) and
Greta.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.atomic_write import atomic_write
from conf.face.animation.gaze import gaze_angles
from conf.face.control_points import CONTROL_POINTS
from conf.face.fapu import UNITS_PER_DISTANCE, Fapu
from conf.face.formats.dpc import MotionClip
from conf.face.head_pose import HeadPose

VERSION = "2.1"
FAP_COUNT = 68
ANGLE_UNIT = 1e-5  # radians
MAX_VALUE = 1_000_000
NAME = "conf"

# Parameter: feature point, axis, sign, and the distance of which its unit is 1/1024.
_POINT_FAPS = """
3  2.1 y - mns0   4  2.2 y - mns0   5  2.3 y + mns0   6  2.4 x + mw0    7  2.5 x - mw0    8  2.6 y - mns0
9  2.7 y - mns0   10 2.8 y + mns0   11 2.9 y + mns0   12 2.4 y + mns0   13 2.5 y + mns0   14 2.1 z + mns0
15 2.1 x - mw0    16 2.3 z + mns0   17 2.2 z + mns0   18 2.10 y + mns0  19 3.1 y - irisd0 20 3.2 y - irisd0
21 3.3 y + irisd0 22 3.4 y + irisd0 31 4.1 y + ens0   32 4.2 y + ens0   33 4.3 y + ens0   34 4.4 y + ens0
35 4.5 y + ens0   36 4.6 y + ens0   37 4.1 x - es0    38 4.2 x + es0    39 5.1 x + es0    40 5.2 x - es0
41 5.3 y + ens0   42 5.4 y + ens0   51 8.1 y - mns0   52 8.2 y + mns0   53 8.3 x + mw0    54 8.4 x - mw0
55 8.5 y - mns0   56 8.6 y - mns0   57 8.7 y + mns0   58 8.8 y + mns0   59 8.3 y + mns0   60 8.4 y + mns0
61 9.1 x + ens0   62 9.2 x - ens0
"""
# Angles: the eyeballs' yaw and pitch (pitch is positive downwards), then the head's pitch, yaw and roll.
_GAZE_FAPS = {23: (0, 0, 1), 24: (1, 0, 1), 25: (0, 1, -1), 26: (1, 1, -1)}  # (eye, angle, sign)
_HEAD_FAPS = (48, 49, 50)


@dataclass(frozen=True)
class FapMotion:
    """A motion as facial animation parameters.

    values : (N, 68) int32, parameter 1 first; 0 for unused parameters
    used : (68,) bool
    """

    fps: float
    values: NDArray[np.int32]
    used: NDArray[np.bool_]


def to_faps(motion: MotionClip, fapu: Fapu, /) -> FapMotion:
    """Return a motion as facial animation parameters.

    motion : of the fifty control points, in FAPU units
    fapu : the distances of the face; some parameters have another unit than the displacements
    Raises ValueError if the motion is in mesh units.
    """
    if motion.units != "fapu":
        raise ValueError(f"motion must be in FAPU units, got {motion.units}")
    lengths = fapu.lengths()
    values = np.zeros((len(motion.displacements), FAP_COUNT))
    used = np.zeros(FAP_COUNT, np.bool_)
    for number, point, axis, sign, unit in _point_faps():
        unit_length = getattr(fapu, unit) / UNITS_PER_DISTANCE
        values[:, number - 1] = motion.displacements[:, point, axis] * (sign * lengths[point, axis] / unit_length)
        used[number - 1] = True
    angles = gaze_angles(motion.displacements)
    for number, (eye, angle, sign) in _GAZE_FAPS.items():
        values[:, number - 1] = sign * angles[:, eye, angle] / ANGLE_UNIT
        used[number - 1] = True
    if motion.poses is not None:
        values[:, np.array(_HEAD_FAPS) - 1] = [_head_angles(pose) for pose in motion.poses]
        used[np.array(_HEAD_FAPS) - 1] = True
    return FapMotion(motion.fps, np.rint(values.clip(-MAX_VALUE, MAX_VALUE)).astype(np.int32), used)


def write_fap(path: Path | str, motion: FapMotion, /) -> None:
    """Write parameters as text, the frame rate rounded to whole frames a second. Raises ValueError without frames."""
    if len(motion.values) == 0 or motion.values.shape[1] != FAP_COUNT:
        raise ValueError(f"values must have shape (frames, {FAP_COUNT}), got {motion.values.shape}")
    mask = " ".join(str(int(used)) for used in motion.used)
    with atomic_write(path) as partial, partial.open("w", encoding="utf-8") as file:
        file.write(f"{VERSION} {NAME} {max(1, round(motion.fps))} {len(motion.values)}\n")
        for i, values in enumerate(motion.values[:, motion.used].tolist()):
            file.write(f"{mask}\n{' '.join(map(str, (i, *values)))}\n")


def _head_angles(pose: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return pitch downwards, yaw to the left and roll to the right in units of ANGLE_UNIT."""
    yaw, pitch, roll = np.radians(HeadPose.from_vector(pose).yaw_pitch_roll()) / ANGLE_UNIT
    return -pitch, yaw, roll


def _point_faps() -> Iterator[tuple[int, int, int, int, str]]:
    """Yield (parameter, control point, axis, sign, unit)."""
    index = {point.feature_point: point.index for point in CONTROL_POINTS}
    words = _POINT_FAPS.split()
    for number, point, axis, sign, unit in zip(*(words[i::5] for i in range(5)), strict=True):
        yield int(number), index[point], "xyz".index(axis), {"+": 1, "-": -1}[sign], unit
