"""Blend the targets of the base figure to the character of a head and align it to the canonical face."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tools.assets.head.control_vertices import VERTICES
from tools.assets.head.parameters import ShapeParameters
from tools.assets.head.source import BaseMesh, Source

ES0_CM = 6.4

_TWO_SIDED = ("eyes", "cheek", "ears")  # folders whose targets are of one side


@dataclass(frozen=True)
class Character:
    """The figure in model centimetres, origin between the eyes, with its 52 blendshapes.

    base : topology; vertices : (V, 3); shapes : name -> (V, 3) offsets
    layout : (V, 3) vertices of the default head, by which faces are classified, unwrapped and painted, so that all
        heads have one topology and one layout of the texture; None for the default head itself
    turn : (3, 3) rotation and scale from the shapes of the base figure to these
    """

    base: BaseMesh
    vertices: NDArray[np.float64]
    shapes: dict[str, NDArray[np.float64]]
    layout: NDArray[np.float64] | None = None
    turn: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))

    @property
    def canonical(self) -> NDArray[np.float64]:
        """The (V, 3) vertices of the default head."""
        return self.vertices if self.layout is None else self.layout

    def eye_helper(self, side: str) -> NDArray[np.float64]:
        """Return the vertices of the eye helper of side "l" or "r"."""
        return self.vertices[self.base.members(f"helper-{side}-eye")]


def build_character(source: Source, shape: ShapeParameters, layout: NDArray[np.float64] | None = None) -> Character:
    """Blend the targets and scale the figure to a distance of the eye centres of ES0_CM.

    layout : (V, 3) vertices of the default head, None if this is it
    """
    base = source.read_base()
    count = len(base.vertices)
    blended = base.vertices.copy()
    for name, weight in target_weights(shape).items():
        blended += weight * source.read_target(name, count)
    left, right = (blended[base.members(f"helper-{side}-eye")].mean(axis=0) for side in "lr")
    scale = ES0_CM / np.linalg.norm(left - right)
    shapes = {name: offsets * scale for name, offsets in source.read_face_units(count).items()}
    return Character(base, (blended - (left + right) / 2) * scale, shapes, layout, np.eye(3) * scale)


def target_weights(shape: ShapeParameters) -> dict[str, float]:
    """Return the weight of each modelling target, those without effect left out."""
    weights: dict[str, float] = {}
    for name, weight in shape.details.items():
        folder, target = name.split("/")
        sides = ("l-", "r-") if folder in _TWO_SIDED else ("",)
        weights |= {f"{folder}/{side}{target}": weight for side in sides}
    builds = {"max": shape.heavy, "min": shape.slight, "average": 1 - shape.heavy - shape.slight}
    for age, age_weight in (("young", 1 - shape.old), ("old", shape.old)):
        for sex, sex_weight in shape.sex.items():
            for origin, origin_weight in shape.origin.items():
                weights[f"macrodetails/{origin}-{sex}-{age}"] = age_weight * sex_weight * origin_weight
            for build, weight in builds.items():
                name = f"macrodetails/universal-{sex}-{age}-averagemuscle-{build}weight"
                weights[name] = age_weight * sex_weight * weight
    return {name: weight for name, weight in weights.items() if weight}


def align_to_canonical(character: Character) -> Character:
    """Return the character aligned to the canonical face of the tracker."""
    points = {name: character.vertices[index] for name, index in VERTICES.items()}
    rotation, shift = align(points)
    shapes = {name: offsets @ rotation.T for name, offsets in character.shapes.items()}
    turned = character.vertices @ rotation.T + shift
    return replace(character, vertices=turned, shapes=shapes, turn=rotation @ character.turn)


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
