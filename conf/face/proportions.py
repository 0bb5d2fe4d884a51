"""Give a head the proportions of the person who moves it: eye distance, nose, mouth.

The sender tells the five FAPU distances of its person's neutral face. Their ratios to those of a mean face shift the
head's vertices by smooth fields, each linear in its ratio, so that the head keeps its character and an average person
changes nothing. What touches, such as lips or lids, lies within one field and still touches. Eyeballs stay spheres.
The opening of the eyes keeps that of the head, on which the contact of its lids depends.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel
from conf.face.fapu import UNITS_PER_DISTANCE, Fapu
from conf.face.interpolation import smoothstep

MEAN_DISTANCES = (6.640, 5.035, 2.881, 5.180)  # es0, ens0, mns0, mw0 of conf/sender/motion/mean_face.py, cm
MIN_RATIO, MAX_RATIO = 0.9, 1.1  # beyond which a shift would strain the mesh
_LEAST = 0.004  # a difference that nobody sees, and that rounding on the wire makes
NO_CHANGE = (1.0, 1.0, 1.0, 1.0)

Ratios = tuple[float, float, float, float]  # of es0, ens0, mns0, mw0

# In cm, 6.4 between the pupils.
_EYE_CORE, _EYE_REACH = 1.95, 3.1  # from the centre of an eye: what moves with it, and where nothing moves
_MOUTH_CORE, _MOUTH_REACH = 1.2, 3.2  # above and below the corners of the mouth
_CHEEK = 6.5  # from the middle to where the width of the mouth has no effect
_BACK, _FRONT = -7.5, -0.5  # z: behind, nothing moves; in front, everything
_NECK = 5.5  # from the chin down to where nothing moves


def proportion_ratios(fapu: Sequence[float], /) -> Ratios:
    """Return the bounded ratios of a person's distances to those of a mean face.

    fapu : es0, ens0, mns0, mw0, irisd0, cm
    """
    ratios = np.clip(np.divide(fapu[:4], MEAN_DISTANCES), MIN_RATIO, MAX_RATIO)
    es0, ens0, mns0, mw0 = np.where(np.abs(ratios - 1) < _LEAST, 1.0, ratios).tolist()
    return es0, ens0, mns0, mw0


@dataclass(frozen=True)
class ProportionFields:
    """The fields of one head."""

    face: FaceModel

    @cached_property
    def _fields(self) -> NDArray[np.float32]:
        """The (4, V, 3) shifts of the vertices per unit of each ratio, cm."""
        face, points = self.face, self.face.control_points
        fields = _fields_at(face.mesh.vertices, points)
        for eye in () if face.rig is None else face.rig.eyes:
            fields[:, eye.vertices] = _fields_at(face.mesh.vertices[eye.vertices].mean(axis=0)[None], points)
        return fields.astype(np.float32)

    def deform(
        self,
        displacements: NDArray[np.floating] | None,
        ratios: Ratios,
        shift: NDArray[np.float32] | None,
        /,
        *,
        sender: Fapu | None = None,
    ) -> NDArray[np.float32]:
        """Return the (V, 3) float32 deformed vertices of a head with these proportions, cm.

        displacements : (n, 3) FAPU units, head pose removed; None for the neutral face
        shift : of the vertices for these ratios, None for none
        sender : FAPU of the person who moved, None if unknown
        """
        if displacements is None:
            return self.face.neutral if shift is None else self.face.neutral + shift
        if shift is None:
            return self.face.deform(displacements, sender=sender)
        lengths = Fapu(*ratios, irisd0=1.0).lengths() * UNITS_PER_DISTANCE
        if sender is not None:  # the part of the person's proportions that this head has not taken on
            sender = Fapu(*np.divide(sender.distances, (*ratios, 1.0)).tolist())
        vertices = self.face.deform(displacements * lengths.astype(np.float32), sender=sender)
        vertices += shift
        return vertices

    def shift(self, ratios: Ratios, /) -> NDArray[np.float32] | None:
        """Return the (V, 3) float32 shift of the vertices, cm, None for no change."""
        if ratios == NO_CHANGE:
            return None
        return np.asarray(np.tensordot(np.subtract(ratios, 1).astype(np.float32), self._fields, axes=1))


def _fields_at(positions: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (4, N, 3) fields at (N, 3) positions. points : (n, 3) control points of the head"""
    x, y, z = positions.T
    at = {name: points[index] for name, index in CONTROL_POINT_INDEX.items()}
    eye, nose = at["pupil_l"], at["nose_bottom_edge_l"][1]
    mouth, chin = at["outer_lip_corner_l"], at["chin_bottom"][1]
    front = smoothstep((z - _BACK) / (_FRONT - _BACK))
    fields = np.zeros((4, len(positions), 3))
    distance = np.hypot(np.abs(x) - eye[0], y - eye[1])
    near_eye = smoothstep((_EYE_REACH - distance) / (_EYE_REACH - _EYE_CORE))
    fields[0, :, 0] = np.sign(x) * eye[0] * near_eye * front
    neck = smoothstep((y - (chin - _NECK)) / _NECK) * front
    fields[1, :, 1] = -(eye[1] - nose) * smoothstep((eye[1] - 0.6 - y) / (eye[1] - 0.6 - nose)) * neck
    fields[2, :, 1] = -(nose - mouth[1]) * smoothstep((nose - y) / (nose - mouth[1] - 0.4)) * neck
    near_mouth = smoothstep((_MOUTH_REACH - np.abs(y - mouth[1])) / (_MOUTH_REACH - _MOUTH_CORE))
    side = smoothstep((_CHEEK - np.abs(x)) / (_CHEEK - mouth[0]))
    fields[3, :, 0] = np.sign(x) * np.minimum(np.abs(x), mouth[0]) * side * near_mouth * front
    return fields
