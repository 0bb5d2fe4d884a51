"""Motion as ARKit blendshape weights, in a CSV table like those of Live Link Face, which most animation programs read.

The weights are a linear function of the displacements of the control points and of their sizes, clipped to 0 to 1. It
was learned from tracked people, whose shapes the tracker's own network gave, and from the shipped head's sculpted
shapes (tools/train/arkit.py).
Source: the columns of Epic's Live Link Face recordings; Hoerl, Kennard 1970 (ridge regression).
"""

import csv
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.atomic_write import atomic_write
from conf.face.animation.gaze import gaze_angles
from conf.face.formats.dpc import MotionClip
from conf.face.head_pose import HeadPose

SHAPES = tuple(
    """
    eyeBlinkLeft eyeLookDownLeft eyeLookInLeft eyeLookOutLeft eyeLookUpLeft eyeSquintLeft eyeWideLeft eyeBlinkRight
    eyeLookDownRight eyeLookInRight eyeLookOutRight eyeLookUpRight eyeSquintRight eyeWideRight jawForward jawRight
    jawLeft jawOpen mouthClose mouthFunnel mouthPucker mouthRight mouthLeft mouthSmileLeft mouthSmileRight
    mouthFrownLeft mouthFrownRight mouthDimpleLeft mouthDimpleRight mouthStretchLeft mouthStretchRight mouthRollLower
    mouthRollUpper mouthShrugLower mouthShrugUpper mouthPressLeft mouthPressRight mouthLowerDownLeft
    mouthLowerDownRight mouthUpperUpLeft mouthUpperUpRight browDownLeft browDownRight browInnerUp browOuterUpLeft
    browOuterUpRight cheekPuff cheekSquintLeft cheekSquintRight noseSneerLeft noseSneerRight tongueOut
    """.split()
)
ROTATIONS = tuple(f"{part}{angle}" for part in ("Head", "LeftEye", "RightEye") for angle in ("Yaw", "Pitch", "Roll"))
HEADER = ("Timecode", "BlendShapeCount", *(name[0].upper() + name[1:] for name in SHAPES), *ROTATIONS)
# What a face cannot do at once, such as looking up and down: the map gives them opposite signs.
OPPOSITES = (
    ("mouthLeft", "mouthRight"),
    ("jawLeft", "jawRight"),
    *(
        (f"eyeLook{a}{side}", f"eyeLook{b}{side}")
        for a, b in (("Up", "Down"), ("In", "Out"))
        for side in ("Left", "Right")
    ),
)


@cache
def _load_map() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the (6 n + 1, 52) linear map and the (3 n,) scales of its features, FAPU units."""
    with (files("conf.assets") / "arkit.npz").open("rb") as file, np.load(file) as arrays:
        return arrays["map"].astype(np.float64), arrays["scale"].astype(np.float64)


def shape_features(displacements: NDArray[np.floating], scale: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return the (N, 6 n + 1) features of motions that the map takes: the displacements, their sizes, and one.

    displacements : (N, n, 3) FAPU units; scale : (3 n,)
    """
    scaled = np.asarray(displacements, np.float64).reshape(len(displacements), -1) / scale
    return np.hstack([scaled, np.abs(scaled) / 2, np.ones((len(scaled), 1))])


def arkit_weights(displacements: NDArray[np.floating], /) -> NDArray[np.float32]:
    """Return the (N, 52) weights, 0 to 1, in the order of SHAPES, of a motion. Of opposites at most one is above 0.

    displacements : (N, n, 3) FAPU units
    """
    weights, scale = _load_map()
    return np.clip(shape_features(displacements, scale) @ weights, 0.0, 1.0).astype(np.float32)


def write_blendshape_csv(
    path: Path | str, motion: MotionClip, /, *, weights: NDArray[np.floating] | None = None
) -> None:
    """Write a motion, in FAPU units, with a line for each frame: time code, 52 weights, 9 rotations in radians.

    weights : (N, 52) in the order of SHAPES; None derives them from the motion
    Raises ValueError if the motion is in mesh units.
    """
    if motion.units != "fapu":
        raise ValueError(f"motion must be in FAPU units, got {motion.units}")
    if weights is None:
        weights = arkit_weights(motion.displacements)
    rows = np.hstack([weights, _rotations(motion)]).tolist()
    with atomic_write(path) as partial, partial.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(HEADER)
        for i, row in enumerate(rows):
            table.writerow([timecode(i, motion.fps), len(row), *(f"{value:.6f}" for value in row)])


def timecode(frame: int, fps: float, /) -> str:
    """Return the time of a frame as HH:MM:SS:FF.FFF, with thousandths of a frame."""
    whole = max(1, round(fps))
    ticks = round(frame / fps * whole * 1000)
    seconds, ticks = divmod(ticks, whole * 1000)
    return f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}:{ticks // 1000:02d}.{ticks % 1000:03d}"


def _rotations(motion: MotionClip) -> NDArray[np.float64]:
    """Return (N, 9): yaw to the subject's left, pitch up and roll to the right of head, left eye and right eye.

    The signs are those of programs that feed Live Link from MediaPipe (MeFaMo) and from ARKit, which has the same axes:
    x to the subject's left, y up, z out of the face.
    """
    angles = np.zeros((len(motion.displacements), 3, 3))
    angles[:, 1:, :2] = gaze_angles(motion.displacements)
    if motion.poses is not None:
        angles[:, 0] = np.radians([HeadPose.from_vector(pose).yaw_pitch_roll() for pose in motion.poses])
    return angles.reshape(len(angles), -1)
