"""The muscles of a face, defined by its control points: nine pairs and the ring around the mouth.

The ends of a muscle are weighted sums of control points with weights that add up to one, so that they fit any face.
Names and courses are those of anatomy, as in figure 4.9 of the thesis.
Source: Waters 1987; Noh, Neumann 1998.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, LOWER_LIP
from conf.face.deformation.face_model import FaceModel
from conf.face.deformation.regions import split_regions
from conf.face.deformation.rig import jaw_offsets
from conf.face.deformation.waters_muscles import LinearMuscle, MuscleSet, Sphincter
from conf.face.mesh.surface_graph import SurfaceGraph

SPHINCTER = "orbicularis_oris"
PointWeights = Mapping[str, float]  # control point without its side -> weight


@dataclass(frozen=True)
class MuscleCourse:
    """The course of one muscle of a pair, by control points of its own side.

    angle, start, end : as of LinearMuscle, but the angle in degrees
    lip : "upper" or "lower" if the muscle moves that lip only
    """

    root: PointWeights
    insertion: PointWeights
    angle: float = 45.0
    start: float = 0.8
    end: float = 1.4
    lip: str | None = None


MUSCLE_COURSES = {
    "zygomatic_major": MuscleCourse(
        {"cheekbone": 1.0, "eye_outer_corner": 0.3, "eye_inner_corner": -0.3},
        {"outer_lip_corner": 1.0}, 32.0, 0.8, 1.4,
    ),
    "risorius": MuscleCourse(
        {"outer_lip_corner": 1.0, "eye_outer_corner": 2.0, "eye_inner_corner": -2.0},
        {"outer_lip_corner": 1.0}, 30.0, 0.9, 1.4,
    ),
    "depressor_anguli": MuscleCourse(
        {"chin_corner": 1.0, "eye_outer_corner": 0.5, "eye_inner_corner": -0.5},
        {"outer_lip_corner": 1.0}, 35.0, 0.8, 1.3,
    ),
    "levator_labii": MuscleCourse(
        {"eye_lower_outer_lid": 0.4, "eye_inner_corner": 0.6}, {"outer_lip_upper": 1.0}, 32.0, 0.9, 1.3, "upper",
    ),
    "levator_nasi": MuscleCourse({"eye_inner_corner": 1.0}, {"nostril_border": 1.0}, 25.0, 0.9, 1.35, "upper"),
    "depressor_labii": MuscleCourse({"chin_corner": 1.0}, {"outer_lip_lower": 1.0}, 45.0, 0.9, 1.5, "lower"),
    "frontalis_inner": MuscleCourse({"brow_inner": 3.4, "eye_inner_corner": -2.4}, {"brow_inner": 1.0}, 30.0, 0.8, 1.4),
    "frontalis_outer": MuscleCourse({"brow_top": 3.2, "eyelid_upper": -2.2}, {"brow_top": 1.0}, 34.0, 0.8, 1.35),
    "corrugator": MuscleCourse(
        {"eye_inner_corner": 0.8, "brow_inner": 1.2, "brow_top": -1.0},
        {"brow_inner": 0.5, "brow_top": 0.5}, 40.0, 0.8, 1.5,
    ),
}  # fmt: skip
# The ring's half axes, depth and protrusion, in half mouth widths.
RING_AXES, RING_DEPTH, RING_PROTRUSION = (1.9, 1.2), 2.0, 1.0


def build_muscles(points: NDArray[np.float64], /) -> dict[str, LinearMuscle | Sphincter]:
    """Return the muscles of a face by name. points : (n, 3) control points, model units."""
    muscles: dict[str, LinearMuscle | Sphincter] = {}
    for name, course in MUSCLE_COURSES.items():
        for side in "lr":
            ends = (_weighted_point(points, course.root, side), _weighted_point(points, course.insertion, side))
            muscles[f"{name}_{side}"] = LinearMuscle(*ends, np.radians(course.angle), course.start, course.end)
    left, right = (points[CONTROL_POINT_INDEX[f"outer_lip_corner_{side}"]] for side in "lr")
    upper, lower = (points[CONTROL_POINT_INDEX[f"outer_lip_{lip}_mid"]] for lip in ("upper", "lower"))
    half = (left - right) / 2
    up = upper - lower
    up = (up - half * (up @ half) / (half @ half)) / np.linalg.norm(up) * np.linalg.norm(half)
    axes = np.array([half * RING_AXES[0], up * RING_AXES[1]])
    half_width = float(np.linalg.norm(half))
    muscles[SPHINCTER] = Sphincter((upper + lower) / 2, axes, RING_DEPTH * half_width, RING_PROTRUSION * half_width)
    return muscles


class MuscleDeformer:
    """A face moved by muscles and a jaw."""

    def __init__(self, face: FaceModel) -> None:
        """Attach the muscles to a face: some tens of milliseconds."""
        self._face = face
        muscles = build_muscles(face.control_points)
        self.muscles = MuscleSet(muscles, face.mesh.vertices, _vertex_weights(face))

    def deform(self, contractions: Mapping[str, float], /, *, jaw: float = 0.0) -> NDArray[np.float32]:
        """Return the deformed vertices, (V, 3) float32, model centimetres.

        contractions : muscle -> 0 relaxed to 1
        jaw : rotation of the jaw, if the face has one, before the muscles pull, radians
        """
        offsets = self.muscles.contract(contractions)
        rig = self._face.rig
        if rig is not None and rig.jaw is not None and jaw:
            motion = rig.jaw.rotation(jaw).astype(np.float32), np.zeros(3, np.float32)
            offsets[rig.jaw.vertices] += jaw_offsets(rig.jaw.weighted_offsets, rig.jaw.weights, motion)
        return np.asarray(self._face.neutral + offsets, np.float32)


def _weighted_point(points: NDArray[np.float64], weights: PointWeights, side: str) -> NDArray[np.float64]:
    rows = [CONTROL_POINT_INDEX[f"{name}_{side}"] for name in weights]
    return np.asarray(np.array(list(weights.values())) @ points[rows])


def _vertex_weights(face: FaceModel) -> dict[str, NDArray[np.float64]]:
    """Return the (V,) weight of each muscle at each vertex: 0 on rigid parts, and on the other lip if it moves one."""
    mesh = face.mesh
    skin = np.ones(len(mesh.vertices))
    if face.rig is not None:
        skin[face.rig.rigid] = 0.0
    surface = SurfaceGraph(mesh.vertices, mesh.triangles)
    regions = split_regions(surface, face.control_points, anchors=np.empty((0, 3)))
    upper = sum(field.weights for field in regions.fields if set(LOWER_LIP) <= set(field.excluded))
    of_lip = {None: skin, "upper": skin * upper, "lower": skin * (1 - upper)}
    weights = {f"{name}_{side}": of_lip[course.lip] for name, course in MUSCLE_COURSES.items() for side in "lr"}
    return {**weights, SPHINCTER: skin}
