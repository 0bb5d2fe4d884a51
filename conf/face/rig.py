"""The parts that do not stretch: eyeballs, lower teeth and tongue; and the lids that slide over the eyeballs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from conf.face.control_points import INDEX

MAX_GAZE = np.radians(40.0)
JAW_RANGE = (np.radians(-1.0), np.radians(35.0))
_CHIN = [INDEX[name] for name in ("chin_bottom", "chin_boss", "chin_corner_l", "chin_corner_r")]


@dataclass(frozen=True)
class Eye:
    """One eyeball.

    centre : (3,) what it turns about, model units
    pupil : index of the control point that leads it
    vertices : its vertices
    lids : vertices of skin and lashes that rest on it
    clearance : (lids,) the distance from the centre below which each of them never comes
    """

    centre: NDArray[np.float64]
    pupil: int
    vertices: NDArray[np.int64]
    lids: NDArray[np.int64]
    clearance: NDArray[np.float64]


@dataclass(frozen=True)
class Jaw:
    """The hinge that the lower teeth and the tongue turn about.

    centre : (3,) a point of the hinge, model units
    axis : (3,) its direction: turning by a positive angle opens the mouth
    vertices : what turns
    """

    centre: NDArray[np.float64]
    axis: NDArray[np.float64]
    vertices: NDArray[np.int64]


@dataclass(frozen=True)
class Rig:
    """The rigid parts of a face and the places that never move.

    anchors : (k, 3) model units
    """

    eyes: tuple[Eye, ...]
    jaw: Jaw | None
    anchors: NDArray[np.float64]

    def pose(
        self,
        neutral: NDArray[np.float32],
        vertices: NDArray[np.float32],
        points: NDArray[np.float64],
        offsets: NDArray[np.floating],
    ) -> None:
        """Overwrite the rigid parts of deformed vertices, in place.

        neutral : (V, 3) undeformed vertices
        vertices : (V, 3) the same, carried by the operator
        points, offsets : (n, 3) neutral control points and how far they have moved, model units
        """
        for eye in self.eyes:
            turn = gaze_rotation(points[eye.pupil] - eye.centre, offsets[eye.pupil])
            vertices[eye.vertices] = _turn(neutral[eye.vertices], eye.centre, turn)
            _push_out(vertices, eye)
        if self.jaw is not None:
            angle, slide = jaw_motion(self.jaw, points, offsets)
            turn = Rotation.from_rotvec(self.jaw.axis * angle).as_matrix()
            vertices[self.jaw.vertices] = _turn(neutral[self.jaw.vertices], self.jaw.centre, turn) + slide


def gaze_rotation(pupil: NDArray[np.float64], offset: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the (3, 3) rotation that brings a pupil to where it is seen.

    pupil : (3,) from the eye's centre, neutral
    offset : (3,) how far the pupil has moved; its depth is not used, the eyeball gives it
    """
    radius = np.linalg.norm(pupil)
    sideways = pupil[:2] + offset[:2]
    reach = radius * np.sin(MAX_GAZE)
    sideways = sideways * min(1.0, reach / max(float(np.linalg.norm(sideways)), 1e-9))
    seen = np.array([*sideways, np.sqrt(radius**2 - sideways @ sideways)])
    axis = np.cross(pupil, seen)
    sine, cosine = np.linalg.norm(axis), pupil @ seen
    return Rotation.from_rotvec(axis * (np.arctan2(sine, cosine) / max(float(sine), 1e-12))).as_matrix()


def jaw_motion(
    jaw: Jaw, points: NDArray[np.float64], offsets: NDArray[np.floating]
) -> tuple[float, NDArray[np.float32]]:
    """Return the angle the chin has turned about the hinge, and how far it has slid sideways, (3,)."""
    chin = points[_CHIN].mean(axis=0) - jaw.centre
    moved = chin + offsets[_CHIN].mean(axis=0)
    across, along = np.cross(jaw.axis, chin), chin - jaw.axis * (jaw.axis @ chin)
    angle = float(np.arctan2(moved @ across, moved @ along))
    slide = jaw.axis * (jaw.axis @ (moved - chin))
    return float(np.clip(angle, *JAW_RANGE)), slide.astype(np.float32)


def _turn(
    places: NDArray[np.float32], centre: NDArray[np.float64], rotation: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Return the (k, 3) places turned about the centre."""
    middle = centre.astype(np.float32)
    turned: NDArray[np.float32] = (places - middle) @ rotation.T.astype(np.float32) + middle
    return turned


def _push_out(vertices: NDArray[np.float32], eye: Eye) -> None:
    """Move lids that a straight path took through the eyeball out to its surface."""
    centre = eye.centre.astype(np.float32)
    from_centre = vertices[eye.lids] - centre
    distance = np.sqrt(np.einsum("ij,ij->i", from_centre, from_centre))
    inside = np.flatnonzero(distance < eye.clearance)
    if len(inside):
        outwards = from_centre[inside] / np.maximum(distance[inside, None], 1e-6)
        vertices[eye.lids[inside]] = centre + outwards * eye.clearance[inside, None]
