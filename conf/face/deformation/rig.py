"""Rigid parts of a face: eyeballs, jaw, lower teeth and tongue; and the lids that slide over the eyeballs.

Strategy. Rigid parts cannot be interpolated: an eyeball would shear, lower teeth would penetrate the chin, and the skin
near the jaw's hinge, below the ears, moves back where the chin moves down. So the jaw's rotation is subtracted from the
control points' displacements, the operator applies the remainder, and the rotation is added to the vertices, each with
its jaw weight.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.constraints.gaze_limits import limit_gaze
from conf.face.deformation.constraints.upper_teeth import UpperTeeth
from conf.face.deformation.eyelids import Lashes, LidCover

MAX_GAZE = np.radians(40.0)
JAW_RANGE = (np.radians(-1.0), np.radians(35.0))  # the teeth meet; the jaw is open as far as it goes
CHIN = [CONTROL_POINT_INDEX[name] for name in ("chin_bottom", "chin_boss", "chin_corner_l", "chin_corner_r")]


@dataclass(frozen=True)
class Eye:
    """One eyeball.

    centre : (3,) of rotation, model units
    pupil : index of the control point that it follows
    vertices : of the eyeball
    lids : vertices of skin that rest on it
    clearance : (lids,) float32, minimum distance of each of them from the centre
    lashes : that stand on the lids, if there are any
    cover : edge of the upper lid, unless blendshapes close the eye
    corners : vertices of skin at its corners
    """

    centre: NDArray[np.float64]
    pupil: int
    vertices: NDArray[np.int64]
    lids: NDArray[np.int64]
    clearance: NDArray[np.float32]
    lashes: Lashes | None = None
    cover: LidCover | None = None
    corners: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))

    def apply(
        self,
        neutral: NDArray[np.float32],
        vertices: NDArray[np.float32],
        points: NDArray[np.float64],
        offsets: NDArray[np.floating],
        /,
    ) -> None:
        """Rotate the eyeball to its pupil, push the lids out of it, and turn the lashes with them.

        neutral, vertices : (V, 3) neutral, and deformed: changed in place
        points, offsets : (n, 3) neutral control points and their offsets
        """
        moved = vertices[self.corners] - neutral[self.corners]
        corners = moved.mean(axis=0) if len(moved) else np.zeros(3)
        offset = limit_gaze(self.pupil, points, offsets, corners)
        rotation = gaze_rotation(points[self.pupil] - self.centre, offset).astype(np.float32)
        centre = self.centre.astype(np.float32)
        vertices[self.vertices] = (neutral[self.vertices] - centre) @ rotation.T + centre
        from_centre = vertices[self.lids] - centre
        distance = np.sqrt(np.einsum("ij,ij->i", from_centre, from_centre))
        inside = np.flatnonzero(distance < self.clearance)
        if len(inside):
            stretch = self.clearance[inside] / np.maximum(distance[inside], np.float32(1e-6))
            vertices[self.lids[inside]] = centre + from_centre[inside] * stretch[:, None]
        if self.cover is not None:
            self.cover.apply(neutral, vertices, centre)
        if self.lashes is not None:
            self.lashes.apply(neutral, vertices, centre)


def gaze_rotation(pupil: NDArray[np.floating], offset: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return the (3, 3) rotation that moves a pupil by an offset as seen from the front, at most MAX_GAZE.

    pupil : (3,) neutral, from the eye's centre
    offset : (3,); its depth is ignored, the pupil stays on the eyeball
    """
    radius = float(np.linalg.norm(pupil))
    sideways = pupil[:2] + offset[:2]
    sideways *= min(1.0, radius * np.sin(MAX_GAZE) / max(float(np.linalg.norm(sideways)), 1e-9))
    target = np.array([*sideways, np.sqrt(radius**2 - sideways @ sideways)])
    cross = cross_matrix(cross_matrix(pupil) @ target / radius**2)
    rotation: NDArray[np.float64] = np.eye(3) + cross + cross @ cross / (1 + pupil @ target / radius**2)
    return rotation


def cross_matrix(vector: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return the (3, 3) matrix of the cross product with a vector: cross_matrix(a) @ b = a x b."""
    x, y, z = vector.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


@dataclass(frozen=True)
class Jaw:
    """The hinge of the lower jaw and what follows it.

    centre : (3,) a point of the hinge, model units
    axis : (3,) unit vector: a positive angle opens the mouth
    vertices : (k,) that follow it: lower teeth and tongue, and skin if blendshapes give its weights
    weights : (k,) float32, of the jaw's motion in each of the vertices, 0 to 1
    weighted_offsets : (k, 3) float32, from the centre to each neutral vertex, times its weight
    point_weights, weighted_point_offsets : the same of the n control points
    """

    centre: NDArray[np.float64]
    axis: NDArray[np.float64]
    vertices: NDArray[np.int64]
    weights: NDArray[np.float32]
    weighted_offsets: NDArray[np.float32]
    point_weights: NDArray[np.float32]
    weighted_point_offsets: NDArray[np.float32]

    def estimate_motion(
        self, points: NDArray[np.float64], offsets: NDArray[np.floating], /
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return the jaw's motion from the chin's: (3, 3) rotation minus identity, (3,) translation along the hinge.

        points, offsets : (n, 3) neutral control points and their offsets, model units
        """
        chin = points[CHIN].mean(axis=0) - self.centre
        offset = offsets[CHIN].mean(axis=0)
        opening = cross_matrix(self.axis) @ chin  # direction of the chin when the jaw opens
        radial = chin - self.axis * (self.axis @ chin)
        angle = np.arctan2(offset @ opening, opening @ opening + offset @ radial)
        angle = min(max(float(angle), JAW_RANGE[0]), JAW_RANGE[1])
        translation = self.axis * (self.axis @ offset)
        return self.rotation(angle).astype(np.float32), translation.astype(np.float32)

    def rotation(self, angle: float, /) -> NDArray[np.float64]:
        """Return the (3, 3) rotation by an angle, radians, about the hinge, minus the identity."""
        cross = cross_matrix(self.axis)  # Rodrigues' rotation formula
        return np.asarray(np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


def jaw_offsets(
    weighted_offsets: NDArray[np.float32],
    weights: NDArray[np.float32],
    motion: tuple[NDArray[np.float32], NDArray[np.float32]],
    /,
) -> NDArray[np.float32]:
    """Return the (k, 3) offsets of vertices, or of control points, for a motion of the jaw."""
    rotation, translation = motion
    offsets: NDArray[np.float32] = weighted_offsets @ rotation.T + weights[:, None] * translation
    return offsets


@dataclass(frozen=True)
class EyelidHelpers:
    """Points on the edges of one face's eyelids, between the control points.

    positions : (h, 3), in the unit of the control points
    weights : (h, n) of the control points' displacements in each helper point's
    lids : (h,) control point of the lid or brow that each belongs to
    """

    positions: NDArray[np.float64]
    weights: NDArray[np.float64]
    lids: NDArray[np.intp]


@dataclass(frozen=True)
class Rig:
    """The rigid parts of a face, and its anchors.

    anchors : (k, 3) positions that never move, model units
    rigid : vertices that the skin does not move: eyeballs, teeth, tongue
    eyelid_helpers : on the edges of the lids, if these were measured
    upper_teeth : if the face has any
    """

    eyes: tuple[Eye, ...]
    jaw: Jaw | None
    anchors: NDArray[np.float64]
    rigid: NDArray[np.int64]
    eyelid_helpers: EyelidHelpers | None = None
    upper_teeth: UpperTeeth | None = None
