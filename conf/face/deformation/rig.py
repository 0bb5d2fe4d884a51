"""The parts that do not stretch: eyeballs, jaw, lower teeth and tongue; and the lids that slide over the eyeballs.

Strategy. What turns must not be moved by interpolation: an eyeball would shear, lower teeth would poke through the
chin, and the skin below the ears, near the hinge, moves back where the chin moves down. So the jaw's turn is taken
out of the control points' displacements, the operator carries what is left, and the turn is put back on the
vertices, each by its share in the jaw.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.eyelid_helpers import EyelidHelpers

MAX_GAZE = np.radians(40.0)
JAW_RANGE = (np.radians(-1.0), np.radians(35.0))  # the teeth meet; as wide as a jaw opens
CHIN = [CONTROL_POINT_INDEX[name] for name in ("chin_bottom", "chin_boss", "chin_corner_l", "chin_corner_r")]


@dataclass(frozen=True)
class Eye:
    """One eyeball.

    centre : (3,) what it turns about, model units
    pupil : index of the control point that leads it
    vertices : its vertices
    lids : the vertices of skin that rest on it
    clearance : (lids,) float32, the distance from the centre below which each of them never comes
    """

    centre: NDArray[np.float64]
    pupil: int
    vertices: NDArray[np.int64]
    lids: NDArray[np.int64]
    clearance: NDArray[np.float32]

    def apply(
        self, neutral: NDArray[np.float32], vertices: NDArray[np.float32], pupil: NDArray[np.floating], /
    ) -> None:
        """Turn the eyeball to its pupil and bring the lids out of it.

        neutral, vertices : (V, 3) the face at rest, and moved: changed in place
        pupil : (2, 3) the pupil at rest, and how far it has moved
        """
        rest, offset = pupil
        rotation = gaze_rotation(rest - self.centre, offset).astype(np.float32)
        centre = self.centre.astype(np.float32)
        vertices[self.vertices] = (neutral[self.vertices] - centre) @ rotation.T + centre
        from_centre = vertices[self.lids] - centre
        distance = np.sqrt(np.einsum("ij,ij->i", from_centre, from_centre))
        inside = np.flatnonzero(distance < self.clearance)
        if len(inside):
            stretch = self.clearance[inside] / np.maximum(distance[inside], np.float32(1e-6))
            vertices[self.lids[inside]] = centre + from_centre[inside] * stretch[:, None]


def gaze_rotation(pupil: NDArray[np.floating], offset: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return the (3, 3) rotation that brings a pupil to where it is seen from the front.

    pupil : (3,) at rest, from the eye's centre
    offset : (3,) how far it has moved; the depth is not used, the eyeball gives it
    """
    radius = float(np.linalg.norm(pupil))
    sideways = pupil[:2] + offset[:2]
    sideways *= min(1.0, radius * np.sin(MAX_GAZE) / max(float(np.linalg.norm(sideways)), 1e-9))
    seen = np.array([*sideways, np.sqrt(radius**2 - sideways @ sideways)])
    across = cross_matrix(cross_matrix(pupil) @ seen / radius**2)
    turn: NDArray[np.float64] = np.eye(3) + across + across @ across / (1 + pupil @ seen / radius**2)
    return turn


def cross_matrix(vector: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return the (3, 3) matrix that multiplies a vector as the cross product with this one does."""
    x, y, z = vector.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


@dataclass(frozen=True)
class Jaw:
    """The hinge of the lower jaw and what follows it.

    centre : (3,) a point of the hinge, model units
    axis : (3,) its unit direction: a positive angle opens the mouth
    vertices : what follows it: lower teeth and tongue, and skin where it is known how far
    shares : (k,) float32, how far each of the vertices follows, 0 to 1
    arms : (k, 3) float32, from the centre to each vertex at rest, times its share
    point_shares, point_arms : the same of the n control points
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
        """Return how the chin has turned about the hinge, (3, 3) rotation less identity, and slid along it, (3,).

        points, offsets : (n, 3) control points at rest and how far they have moved, model units
        """
        chin = points[CHIN].mean(axis=0) - self.centre
        shift = offsets[CHIN].mean(axis=0)
        across = cross_matrix(self.axis)
        sideways = across @ chin  # where the chin goes when the jaw opens
        angle = np.arctan2(shift @ sideways, sideways @ sideways + shift @ (chin - self.axis * (self.axis @ chin)))
        angle = min(max(float(angle), JAW_RANGE[0]), JAW_RANGE[1])
        turn = np.sin(angle) * across + (1 - np.cos(angle)) * across @ across
        slide = self.axis * (self.axis @ shift)
        return turn.astype(np.float32), slide.astype(np.float32)


def jaw_offsets(
    weighted_offsets: NDArray[np.float32],
    weights: NDArray[np.float32],
    motion: tuple[NDArray[np.float32], NDArray[np.float32]],
    /,
) -> NDArray[np.float32]:
    """Return the (k, 3) offsets that a motion of the jaw gives to what follows it by such shares."""
    turn, slide = motion
    offsets: NDArray[np.float32] = weighted_offsets @ turn.T + weights[:, None] * slide
    return offsets


@dataclass(frozen=True)
class Rig:
    """The rigid parts of a face, and the places that never move.

    anchors : (k, 3) model units
    rigid : the vertices that skin does not carry: eyeballs, teeth, tongue
    margins : where the edges of the lids are, if they were measured
    """

    eyes: tuple[Eye, ...]
    jaw: Jaw | None
    anchors: NDArray[np.float64]
    rigid: NDArray[np.int64]
    eyelid_helpers: EyelidHelpers | None = None
