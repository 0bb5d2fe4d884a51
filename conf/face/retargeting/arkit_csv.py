"""Motion as the weights of 52 shapes, in a table like those of Live Link Face: most animation programs read it.

The weights are those of the shipped head's sculpted shapes, which bear ARKit's names, that together come nearest to
the displacements of the control points, none below 0 or above 1.
Source: the columns are those of Epic's Live Link Face recordings; least squares: Lawson, Hanson 1974.
"""

import csv
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import lsq_linear, nnls

from conf.face.animation.gaze import gaze_angles
from conf.face.formats.dpc import MotionClip
from conf.face.head_pose import HeadPose
from conf.face.loading import load_face
from conf.face.retargeting.arkit_shapes import load_arkit_shapes

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

# cm^2. Of shapes that do nearly the same, both a little rather than one a lot, and no opposites against each other: on
# a tracked smile 1e-4 looked left and right at full strength at once, 1e-2 took 7 % off true shapes.
REGULARISATION = 3e-3


def solve_arkit_weights(displacements: NDArray[np.floating], /) -> NDArray[np.float32]:
    """Return the (N, 52) weights, 0 to 1, in the order of SHAPES, that come nearest to a motion.

    displacements : (N, n, 3) FAPU units
    """
    basis, lengths = _sculpted_basis()
    wanted = (np.asarray(displacements, np.float64) * lengths).reshape(len(displacements), -1)
    return bounded_least_squares(basis, wanted).astype(np.float32)


@cache
def _sculpted_basis() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the (52, 3 n) shapes at the control points in centimetres, and the (n, 3) lengths of FAPU units."""
    lengths = load_face().fapu.lengths()
    return np.stack([(load_arkit_shapes()[name] * lengths).ravel() for name in SHAPES]), lengths


def bounded_least_squares(
    basis: NDArray[np.float64], targets: NDArray[np.float64], /, *, regularisation: float = REGULARISATION
) -> NDArray[np.float64]:
    """Return the (N, S) weights in 0..1 that minimise |weights basis - wanted|^2 + regularisation |weights|^2.

    basis : (S, m); wanted : (N, m)
    """
    # Both sides multiplied by the basis: S equations for each frame instead of m.
    gram = basis @ basis.T + regularisation * np.eye(len(basis))
    root = np.asarray(np.linalg.cholesky(gram), np.float64)
    targets = np.asarray(solve_triangular(root, basis @ targets.T, lower=True), np.float64).T
    return np.array([_bounded(root.T, target) for target in targets]).reshape(len(targets), len(basis))


def _bounded(matrix: NDArray[np.float64], target: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (S,) weights in 0..1; few frames reach 1, and without that bound the search is ten times as fast."""
    weights: NDArray[np.float64] = nnls(matrix, target)[0]
    if weights.max() > 1.0:
        weights = lsq_linear(matrix, target, (0.0, 1.0), method="bvls").x
    return np.clip(weights, 0.0, 1.0)


def write_blendshape_csv(path: Path | str, motion: MotionClip, /) -> None:
    """Write a motion, in FAPU units, as a table of one line a frame: time code, 52 weights, 9 rotations in radians.

    Raises ValueError if the motion is in mesh units.
    """
    if motion.units != "fapu":
        raise ValueError(f"motion must be in FAPU units, got {motion.units}")
    rows = np.hstack([solve_arkit_weights(motion.displacements), _rotations(motion)]).tolist()
    with Path(path).open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(HEADER)
        for i, row in enumerate(rows):
            table.writerow([timecode(i, motion.fps), len(row), *(f"{value:.6f}" for value in row)])


def timecode(frame: int, fps: float, /) -> str:
    """Return the hours, minutes, seconds and frames, with thousandths of a frame, at which a frame is due."""
    whole = max(1, round(fps))
    ticks = round(frame / fps * whole * 1000)
    seconds, ticks = divmod(ticks, whole * 1000)
    return f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}:{ticks // 1000:02d}.{ticks % 1000:03d}"


def _rotations(motion: MotionClip) -> NDArray[np.float64]:
    """Return (N, 9): yaw to the subject's left, pitch up and roll to the right of head, left eye and right eye.

    The signs are those of programs that feed Live Link from MediaPipe (MeFaMo) and from ARKit, whose axes are ours:
    x to the subject's left, y up, z out of the face.
    """
    turns = np.zeros((len(motion.displacements), 3, 3))
    turns[:, 1:, :2] = gaze_angles(motion.displacements)
    if motion.poses is not None:
        turns[:, 0] = np.radians([HeadPose.from_vector(pose).yaw_pitch_roll() for pose in motion.poses])
    return turns.reshape(len(turns), -1)
