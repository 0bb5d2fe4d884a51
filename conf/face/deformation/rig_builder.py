"""Put a rig together: eyeballs about their centres, the jaw about its hinge, on a mesh with groups that name them."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.blendshapes import Blendshapes
from conf.face.deformation.ridge_refinement import jaw_weights
from conf.face.deformation.rig import Eye, Jaw, Rig
from conf.face.mesh.mesh import Mesh

EYES = {"eye_l": "pupil_l", "eye_r": "pupil_r"}  # group of the eyeball -> control point that leads it
JAW_GROUPS = ("teeth_lower", "tongue")
RIGID_GROUPS = ("teeth_upper", *JAW_GROUPS, *EYES)
_LID_RADII = 1.35  # skin this many eyeball radii from the centre may come to rest on the eyeball
_LID_CLEARANCE_CM = 0.03  # a closed lid stays this far off the eyeball
_MIN_JAW_WEIGHT = 0.02  # skin that follows the jaw less does not follow it


@dataclass(frozen=True)
class RigJoints:
    """What the rigid parts turn about, model units.

    eyes : group of an eyeball -> (3,) its centre
    hinge : (3,) a point of the jaw's hinge and (3,) its direction, or None
    anchors : (k, 3) places that never move
    """

    eyes: Mapping[str, NDArray[np.float64]]
    hinge: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
    anchors: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))


def build_rig(mesh: Mesh, points: NDArray[np.float64], joints: RigJoints, shapes: Blendshapes | None = None, /) -> Rig:
    """Return the rig of a mesh with any of the groups eye_l, eye_r, teeth_upper, teeth_lower and tongue.

    points : (n, 3) control points, model units
    shapes : sculpted shapes of the mesh: they tell how far the skin follows the jaw
    """
    rigid = mesh.group_vertices(*RIGID_GROUPS)
    skin = np.setdiff1d(np.arange(len(mesh.vertices)), rigid)
    return Rig(
        eyes=tuple(_build_eye(mesh, name, centre, skin) for name, centre in joints.eyes.items()),
        jaw=_build_jaw(joints.hinge, mesh, points, shapes) if joints.hinge else None,
        anchors=joints.anchors,
        rigid=rigid,
    )


def _build_eye(mesh: Mesh, name: str, centre: NDArray[np.float64], skin: NDArray[np.int64]) -> Eye:
    ball = mesh.group_vertices(name)
    radius = np.linalg.norm(mesh.vertices[ball] - centre, axis=1).max(initial=0.0)
    distance = np.linalg.norm(mesh.vertices[skin] - centre, axis=1)
    near = distance < _LID_RADII * radius
    return Eye(
        centre=centre,
        pupil=CONTROL_POINT_INDEX[EYES[name]],
        vertices=ball,
        lids=skin[near],
        # What is inside the eyeball at rest may stay as deep, no deeper.
        clearance=np.minimum(distance[near], radius + _LID_CLEARANCE_CM).astype(np.float32),
    )


def _build_jaw(
    hinge: tuple[NDArray[np.float64], NDArray[np.float64]],
    mesh: Mesh,
    points: NDArray[np.float64],
    shapes: Blendshapes | None,
) -> Jaw:
    centre, axis = hinge
    axis = axis / max(float(np.linalg.norm(axis)), 1e-12)
    # Whichever way the axis points: opening moves the chin down.
    opens = np.cross(axis, points[CONTROL_POINT_INDEX["chin_bottom"]] - centre)[1] < 0
    nearest = np.asarray(KDTree(mesh.vertices).query(points)[1])
    shares = np.zeros(len(mesh.vertices)) if shapes is None else jaw_weights(shapes, nearest)
    shares[shares < _MIN_JAW_WEIGHT] = 0.0
    shares[mesh.group_vertices(*RIGID_GROUPS)] = 0.0
    shares[mesh.group_vertices(*JAW_GROUPS)] = 1.0
    vertices = np.flatnonzero(shares)
    arms = (mesh.vertices - centre) * shares[:, None]
    point_arms = (points - centre) * shares[nearest][:, None]
    return Jaw(
        centre=centre,
        axis=axis if opens else -axis,
        vertices=vertices,
        weights=shares[vertices].astype(np.float32),
        weighted_offsets=arms[vertices].astype(np.float32),
        point_weights=shares[nearest].astype(np.float32),
        weighted_point_offsets=point_arms.astype(np.float32),
    )
