"""Motion as ARKit blendshape weights, in a CSV table like those of Live Link Face, which most animation programs read.

The weights, 0 to 1, of the shipped head's 52 sculpted shapes approximate the displacements of the control points.
Source: the columns of Epic's Live Link Face recordings; Lawson, Hanson 1974 (bounded least squares).
"""

import csv
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import lsq_linear, nnls
from scipy.spatial import KDTree

from conf.atomic_write import atomic_write
from conf.face.animation.gaze import EYE_RADIUS, gaze_angles
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.default_head import DEFAULT_HEAD
from conf.face.deformation.blendshapes import load_blendshapes
from conf.face.formats.dpc import MotionClip
from conf.face.head_pose import HeadPose
from conf.face.loading import load_face

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

# cm^2. It distributes the weight over similar shapes and avoids opposing ones: on a tracked smile 1e-4 gave full weight
# to looking left and right at once, 1e-2 reduced true shapes by 7 %.
REGULARISATION = 3e-3
# Direction (x, y) and angle in degrees of the left eye
FULL_GAZE = {"Up": (0, 1, 22.0), "Down": (0, -1, 28.0), "In": (-1, 0, 30.0), "Out": (1, 0, 30.0)}


@cache
def load_arkit_shapes() -> dict[str, NDArray[np.float32]]:
    """Return the (n, 3) displacements, FAPU units, of each of the head's shapes at weight 1, by ARKit name.

    A sculpted gaze shape moves the lids only, because the head's eyeballs are rotated by the pupils' control points.
    Here the pupils are added.
    Raises FileFormatError if an asset is missing or damaged.
    """
    face = load_face()
    shapes = load_blendshapes(DEFAULT_HEAD.with_name("shapes.npz"), len(face.mesh.vertices))
    nearest = np.asarray(KDTree(face.mesh.vertices).query(face.control_points)[1])
    displacements = (shapes.offsets[:, nearest] / face.fapu.lengths()).astype(np.float32)
    by_name = dict(zip(shapes.names, displacements, strict=True))
    for direction, (x, y, degrees) in FULL_GAZE.items():
        distance = EYE_RADIUS * np.sin(np.radians(degrees))
        for side, mirror in (("Left", 1), ("Right", -1)):
            pupil = CONTROL_POINT_INDEX[f"pupil_{side[0].lower()}"]
            by_name[f"eyeLook{direction}{side}"][pupil] = [x * mirror * distance, y * distance, 0.0]
    return by_name


def solve_arkit_weights(displacements: NDArray[np.floating], /) -> NDArray[np.float32]:
    """Return the (N, 52) weights, 0 to 1, in the order of SHAPES, that fit a motion best.

    displacements : (N, n, 3) FAPU units
    """
    basis, lengths = _sculpted_basis()
    targets = (np.asarray(displacements, np.float64) * lengths).reshape(len(displacements), -1)
    return bounded_least_squares(basis, targets).astype(np.float32)


@cache
def _sculpted_basis() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the (52, 3 n) shapes at the control points in centimetres, and the (n, 3) lengths of FAPU units."""
    shapes, lengths = load_arkit_shapes(), load_face().fapu.lengths()
    return np.stack([(shapes[name] * lengths).ravel() for name in SHAPES]), lengths


def bounded_least_squares(
    basis: NDArray[np.float64], targets: NDArray[np.float64], /, *, regularisation: float = REGULARISATION
) -> NDArray[np.float64]:
    """Return the (N, S) weights in 0..1 that minimise |weights basis - targets|^2 + regularisation |weights|^2.

    basis : (S, m); targets : (N, m)
    """
    # Normal equations: S for each frame instead of m.
    gram = basis @ basis.T + regularisation * np.eye(len(basis))
    factor = np.asarray(np.linalg.cholesky(gram), np.float64)
    targets = np.asarray(solve_triangular(factor, basis @ targets.T, lower=True), np.float64).T
    return np.array([_bounded(factor.T, target) for target in targets]).reshape(len(targets), len(basis))


def _bounded(matrix: NDArray[np.float64], target: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (S,) weights in 0..1. Few frames reach 1, and without that bound the solver is ten times as fast."""
    weights: NDArray[np.float64] = nnls(matrix, target)[0]
    if weights.max() > 1.0:
        weights = lsq_linear(matrix, target, (0.0, 1.0), method="bvls").x
    return np.clip(weights, 0.0, 1.0)


def write_blendshape_csv(path: Path | str, motion: MotionClip, /) -> None:
    """Write a motion, in FAPU units, with a line for each frame: time code, 52 weights, 9 rotations in radians.

    Raises ValueError if the motion is in mesh units.
    """
    if motion.units != "fapu":
        raise ValueError(f"motion must be in FAPU units, got {motion.units}")
    rows = np.hstack([solve_arkit_weights(motion.displacements), _rotations(motion)]).tolist()
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
