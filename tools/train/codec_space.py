"""Fit the codec's learned space: a metric of errors, and the principal directions of motion in it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX, control_point_indices
from conf.protocol.codec.reference_frames import POSE_VALUES, ROTATION
from conf.sender.motion.mean_face import MEAN_FACE
from tools.bench.expression_curves import GRADIENTS, NAMES
from tools.bench.tracks import Track

AGES = (1, 2, 3, 4, 6, 8, 12, 16, 24, 40)  # ticks from reference to frame, with separate weights
FINE = ("inner_lip", "outer_lip", "cupids_bow", "eyelid")  # lips and lids carry the meaning
LIP_WEIGHT = 1.25  # of their errors
DEPTH = 0.3  # weight of depth: visible in a rotated head and in the shading
RESIDUAL_STEP = 0.01  # of a point residual, eye distances
STAGGERED = 10  # first components, which are rarely constant

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Space:
    """The metric and the size of a learned space.

    components : enough for separate lid motion; more reduce the error less than a finer step at the same rate
    vertical : weights of vertical errors of points: a blink and a raised brow are short, and their size has a meaning
    pose_step : motion of the points by one step of the pose over that by one of a component: their metric has no curves
    curve_weight : of the squared error of a curve over that of a coordinate
    curve_weights : times that, of single curves: those whose motion is smallest beside what it says
    """

    components: int
    vertical: Mapping[str, float]
    pose_step: float
    curve_weight: float
    curve_weights: Mapping[str, float] = field(default_factory=dict)


SPACE = Space(
    26,
    {"inner_lip": 1.5, "eyelid": 2.0},
    pose_step=0.84,
    curve_weight=4.0,
    curve_weights={
        "brow_knit": 4.0,
        "brow_slant_l": 1.8,
        "brow_slant_r": 1.8,
        "mouth_opening": 1.2,
        "upper_lip_thickness": 1.6,
        "lower_lip_thickness": 2.0,
        "upper_lip_raise": 2.0,
        "lid_l": 1.3,
        "lid_r": 1.3,
        "gaze_x": 2.3,
        "gaze_y": 1.5,
    },
)


def fit_shared(tracks: Sequence[Track], /) -> Arrays:
    """Return the arrays that do not depend on the space."""
    opening = GRADIENTS[NAMES.index("mouth_opening")] * np.mean([track.lengths for track in tracks], axis=0)
    scales = [np.median([frame.pose[5] for frame in track.frames]) for track in tracks]
    arrays = {
        "middle": MEAN_FACE.mean(axis=0),
        "usual_log_scale": np.median(scales),
        "opening": opening.reshape(-1) / _eye_distance(),
        "correction": RESIDUAL_STEP / (_weight(SPACE, tracks) * np.sqrt(CONTROL_POINT_COUNT)),
    }
    stored = {name: np.asarray(array, dtype=np.float32) for name, array in arrays.items()}
    return stored | {"ages": np.array(AGES, dtype=np.uint8)}


def fit_space(space: Space, tracks: Sequence[Track], /) -> Arrays:
    """Return the arrays of a learned space."""
    lengths = np.mean([track.lengths for track in tracks], axis=0)
    root = _metric_root(space, _weight(space, tracks), lengths / _eye_distance())
    motion = np.concatenate([[frame.displacements for frame in track.frames] for track in tracks])
    basis = _principal_directions(motion.reshape(len(motion), -1) @ root, space.components)
    analysis = root @ basis
    pose_unit, motions = _pose_steps(_eye_distance() * space.pose_step)
    arrays = {
        "analysis": analysis,
        "synthesis": basis.T @ np.linalg.inv(root),
        "pose_unit": pose_unit,
        "coupling": (motions / lengths).reshape(POSE_VALUES, -1) @ analysis,
        "stagger": _stagger(space.components),
    }
    return {key: np.asarray(array, dtype=np.float32) for key, array in arrays.items()}


def _eye_distance() -> float:
    eyes = MEAN_FACE[[CONTROL_POINT_INDEX["eye_outer_corner_l"], CONTROL_POINT_INDEX["eye_outer_corner_r"]]]
    return float(np.linalg.norm(eyes[0] - eyes[1]))


def _weight(space: Space, tracks: Sequence[Track]) -> NDArray[np.float64]:
    """Return the (n, 3) weights of errors of coordinates, eye distances per FAPU unit, over sqrt(n)."""
    lengths = np.mean([track.lengths for track in tracks], axis=0)
    importance = np.ones((CONTROL_POINT_COUNT, 3))
    importance[control_point_indices(*FINE)] = LIP_WEIGHT
    for name, vertical in space.vertical.items():
        importance[control_point_indices(name), 1] = vertical
    importance /= np.sqrt(np.mean(importance**2))
    return np.asarray(lengths / _eye_distance() * importance * [1, 1, DEPTH] / np.sqrt(CONTROL_POINT_COUNT))


def _metric_root(space: Space, weight: NDArray[np.float64], lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the symmetric square root (3 n, 3 n) of the metric of displacements.

    weight : (n, 3) of the error of each coordinate; lengths : (n, 3) eye distances per FAPU unit
    """
    curve_weights = np.array([space.curve_weights.get(name, 1.0) for name in NAMES])
    gradients = (GRADIENTS * lengths).reshape(len(NAMES), -1) * curve_weights[:, None]
    metric = np.diag(weight.reshape(-1) ** 2) + space.curve_weight / CONTROL_POINT_COUNT * gradients.T @ gradients
    values, vectors = np.linalg.eigh(metric)
    return np.asarray(vectors * np.sqrt(values) @ vectors.T)


def _principal_directions(motion: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    _, vectors = np.linalg.eigh(motion.T @ motion)  # of the deviation from neutral, not from the mean
    basis = vectors[:, ::-1][:, :count]
    strongest = basis[np.abs(basis).argmax(axis=0), np.arange(count)]
    return np.asarray(basis * np.sign(strongest))  # fix the arbitrary sign of each eigenvector


def _stagger(components: int) -> NDArray[np.float64]:
    """Return half a step (6 + K,) for the values that are rarely constant, 0 for the others."""
    values = np.zeros(POSE_VALUES + components)
    values[ROTATION] = 0.5
    values[POSE_VALUES : POSE_VALUES + STAGGERED] = 0.5
    return values


def _pose_steps(eye_distance: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the pose values (6,) that move the points by one eye distance, and the motions (6, n, 3) in cm."""
    x, y, z = offsets = (MEAN_FACE - MEAN_FACE.mean(axis=0)).T
    zero, one = np.zeros_like(x), np.ones_like(x)
    motions = np.array(
        [offsets, [zero, -z, y], [z, zero, -x], [-y, x, zero], [one, zero, zero], [zero, one, zero]]
    ).transpose(0, 2, 1)  # scaling, rotation about x, y, z, translation right and up
    visible = np.sqrt(np.mean(np.sum((motions * [1, 1, DEPTH]) ** 2, axis=2), axis=1))
    unit = eye_distance / visible
    return unit, motions * unit[:, None, None]
