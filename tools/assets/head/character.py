"""Blend the targets of the base figure to the character of the default head and align it to the canonical face."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tools.assets.head.control_vertices import VERTICES
from tools.assets.head.source import BaseMesh, Source

ES0_CM = 6.4

_SEX = {"male": 0.62, "female": 0.38}
_ORIGIN = {"caucasian": 0.62, "asian": 0.23, "african": 0.15}
_DETAILS = {
    "eyes/l-eye-scale-incr": 0.25,
    "eyes/r-eye-scale-incr": 0.25,
    "mouth/mouth-angles-up": 0.18,
    "head/head-scale-vert-decr": 0.15,
    "neck/neck-scale-horiz-decr": 0.1,
}


@dataclass(frozen=True)
class Character:
    """The figure in model centimetres, origin between the eyes, with its 52 blendshapes.

    base : topology; vertices : (V, 3); shapes : name -> (V, 3) offsets
    """

    base: BaseMesh
    vertices: NDArray[np.float64]
    shapes: dict[str, NDArray[np.float64]]

    def eye_helper(self, side: str) -> NDArray[np.float64]:
        """Return the vertices of the eye helper of side "l" or "r"."""
        return self.vertices[self.base.members(f"helper-{side}-eye")]


def build_character(source: Source) -> Character:
    """Blend the targets and scale the figure to a distance of the eye centres of ES0_CM."""
    base = source.read_base()
    count = len(base.vertices)
    blended = base.vertices.copy()
    for name, weight in _weights().items():
        blended += weight * source.read_target(name, count)
    left, right = (blended[base.members(f"helper-{side}-eye")].mean(axis=0) for side in "lr")
    scale = ES0_CM / np.linalg.norm(left - right)
    shapes = {name: offsets * scale for name, offsets in source.read_face_units(count).items()}
    return Character(base, (blended - (left + right) / 2) * scale, shapes)


def _weights() -> dict[str, float]:
    weights = dict(_DETAILS)
    for sex, sex_weight in _SEX.items():
        for origin, origin_weight in _ORIGIN.items():
            weights[f"macrodetails/{origin}-{sex}-young"] = sex_weight * origin_weight
        weights[f"macrodetails/universal-{sex}-young-averagemuscle-averageweight"] = sex_weight
    return weights


def align_to_canonical(character: Character) -> Character:
    """Return the character aligned to the canonical face of the tracker."""
    points = {name: character.vertices[index] for name, index in VERTICES.items()}
    rotation, shift = align(points)
    shapes = {name: offsets @ rotation.T for name, offsets in character.shapes.items()}
    return Character(character.base, character.vertices @ rotation.T + shift, shapes)


# Landmarks of MediaPipe's canonical face model (cm, x to the subject's left, y up, z to the viewer), midline and left;
# the model is symmetric. Source: geometry metadata of face_landmarker.task.
CANONICAL = {
    "chin_bottom": (0.000, -9.403, 4.264),
    "inner_lip_upper_mid": (0.000, -3.994, 5.219),
    "inner_lip_lower_mid": (0.000, -4.542, 5.405),
    "inner_lip_corner_l": (2.153, -4.276, 4.038),
    "inner_lip_upper_l": (1.024, -3.990, 4.927),
    "inner_lip_lower_l": (1.099, -4.459, 5.121),
    "chin_boss": (0.000, -7.942, 5.181),
    "eyelid_upper_l": (3.177, 2.964, 3.877),
    "eyelid_lower_l": (3.177, 2.294, 3.776),
    "eye_outer_corner_l": (4.446, 2.664, 3.173),
    "eye_inner_corner_l": (1.856, 2.585, 3.758),
    "outer_lip_upper_mid": (0.000, -3.406, 5.980),
    "outer_lip_lower_mid": (0.000, -5.365, 5.535),
    "outer_lip_corner_l": (2.456, -4.343, 4.284),
    "outer_lip_upper_l": (1.432, -3.501, 5.496),
    "outer_lip_lower_l": (1.325, -5.107, 5.205),
    "cupids_bow_l": (0.711, -3.329, 5.877),
    "nostril_border_l": (1.786, -0.978, 4.850),
    "nose_bottom_edge_l": (1.406, -1.714, 5.241),
}


def align(points: dict[str, NDArray[np.float64]]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the rotation (3, 3) and translation (3,) that align the named points to the canonical ones, least squares.

    Both faces are symmetric, so only pitch and a shift in the plane of symmetry remain.
    """
    names = [name for name in CANONICAL if name in points]
    source = np.array([points[name] for name in names])
    target = np.array([CANONICAL[name] for name in names])
    flip = np.array([-1.0, 1.0, 1.0])
    source, target = np.vstack([source, source * flip]), np.vstack([target, target * flip])
    rotation = Rotation.align_vectors(target - target.mean(axis=0), source - source.mean(axis=0))[0].as_matrix()
    shift = target.mean(axis=0) - rotation @ source.mean(axis=0)
    return rotation, shift * [0.0, 1.0, 1.0]
