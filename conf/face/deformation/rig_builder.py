"""Build the rig of a mesh with the groups eye_l, eye_r, teeth_upper, teeth_lower and tongue, from its joints.

The joints of the default head are read from rig.json.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from conf.errors import FileFormatError
from conf.face.control_points import CONTROL_POINT_INDEX, EYE_CORNERS
from conf.face.deformation.blendshapes import Blendshapes
from conf.face.deformation.constraints.upper_teeth import find_upper_teeth
from conf.face.deformation.eyelids import find_lashes, find_lid_cover
from conf.face.deformation.ridge_refinement import jaw_weights
from conf.face.deformation.rig import Eye, Jaw, Rig
from conf.face.formats.text import check_file
from conf.face.mesh.mesh import Mesh

EYES = {"eye_l": "pupil_l", "eye_r": "pupil_r"}  # group of the eyeball -> control point that it follows
_CORNERS = dict(zip(EYES, EYE_CORNERS, strict=True))
JAW_GROUPS = ("teeth_lower", "tongue")
RIGID_GROUPS = ("teeth_upper", *JAW_GROUPS, *EYES)
_LID_RADII = 1.35  # eyeball radii from the centre within which skin may come to rest on the eyeball
_LID_CLEARANCE_CM = 0.03  # from the eyeball to a closed lid
_MIN_JAW_WEIGHT = 0.02  # skin with less does not follow the jaw
_MAX_FILE_BYTES = 1 << 20
_MAX_COORDINATE = 1e6


@dataclass(frozen=True)
class RigJoints:
    """The joints of the rigid parts, model units.

    eyes : group of an eyeball -> (3,) its centre
    hinge : (3,) a point of the jaw's hinge and (3,) its direction, or None
    anchors : (k, 3) positions that never move
    """

    eyes: Mapping[str, NDArray[np.float64]]
    hinge: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
    anchors: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))


def read_joints(path: Path, /) -> RigJoints:
    """Read the joints of a head. Raises FileFormatError if the file does not hold them."""
    check_file(path, max_bytes=_MAX_FILE_BYTES)
    try:
        return parse_joints(path.read_bytes())
    except (OSError, ValueError) as error:
        raise FileFormatError(path, None, "expected a rig: eyes, jaw and anchors with their coordinates") from error


def parse_joints(data: bytes, /) -> RigJoints:
    """Return the joints of a head in JSON. Raises ValueError if it does not hold them."""
    try:
        rig = json.loads(data)
        return RigJoints(
            eyes={name: _coordinates(rig[name]["centre"]) for name in EYES if name in rig},
            hinge=(_coordinates(rig["jaw"]["centre"]), _coordinates(rig["jaw"]["axis"])) if "jaw" in rig else None,
            anchors=_coordinates(rig.get("anchors", []), (-1, 3)),
        )
    except (KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ValueError("not a rig: eyes, jaw and anchors with their coordinates") from error


def _coordinates(value: Any, shape: tuple[int, ...] = (3,)) -> NDArray[np.float64]:
    array = np.array(value, dtype=np.float64).reshape(shape)
    if not np.isfinite(array).all() or np.abs(array).max(initial=0.0) > _MAX_COORDINATE:
        raise ValueError("a coordinate out of range")
    return array


def build_rig(
    mesh: Mesh, points: NDArray[np.float64], joints: RigJoints, blendshapes: Blendshapes | None = None, /
) -> Rig:
    """Return the rig of a mesh that has any of the groups.

    points : (n, 3) control points, model units
    blendshapes : of the mesh; they give the weights by which skin follows the jaw
    """
    rigid = mesh.group_vertices(*RIGID_GROUPS)
    skin = np.setdiff1d(np.arange(len(mesh.vertices)), rigid)
    return Rig(
        eyes=tuple(
            _build_eye(mesh, points, name, centre, skin, is_interpolated=blendshapes is None)
            for name, centre in joints.eyes.items()
        ),
        jaw=_build_jaw(joints.hinge, mesh, points, blendshapes) if joints.hinge else None,
        anchors=joints.anchors,
        rigid=rigid,
        upper_teeth=find_upper_teeth(mesh.vertices, mesh.group_vertices("teeth_upper"), points),
    )


def _build_eye(
    mesh: Mesh,
    points: NDArray[np.float64],
    name: str,
    centre: NDArray[np.float64],
    skin: NDArray[np.int64],
    *,
    is_interpolated: bool,
) -> Eye:
    eyeball = mesh.group_vertices(name)
    radius = np.linalg.norm(mesh.vertices[eyeball] - centre, axis=1).max(initial=0.0)
    distance = np.linalg.norm(mesh.vertices[skin] - centre, axis=1)
    near = distance < _LID_RADII * radius
    return Eye(
        centre=centre,
        pupil=CONTROL_POINT_INDEX[EYES[name]],
        vertices=eyeball,
        lids=skin[near],
        # Skin that is inside the eyeball in the neutral pose may stay as deep, but not deeper.
        clearance=np.minimum(distance[near], radius + _LID_CLEARANCE_CM).astype(np.float32),
        lashes=find_lashes(mesh, points, centre, skin, side=name[-1]) if len(eyeball) else None,
        cover=find_lid_cover(mesh, points, skin, side=name[-1]) if len(eyeball) and is_interpolated else None,
        corners=_nearest_skin(mesh, points[_CORNERS[name]], skin),
    )


def _nearest_skin(mesh: Mesh, positions: NDArray[np.float64], skin: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the vertex of the skin nearest to each position (k, 3); none without skin."""
    return skin[KDTree(mesh.vertices[skin]).query(positions)[1]] if len(skin) else skin


def _build_jaw(
    hinge: tuple[NDArray[np.float64], NDArray[np.float64]],
    mesh: Mesh,
    points: NDArray[np.float64],
    blendshapes: Blendshapes | None,
) -> Jaw:
    centre, axis = hinge
    axis = axis / max(float(np.linalg.norm(axis)), 1e-12)
    # Orient the axis so that a positive angle moves the chin down.
    opens = np.cross(axis, points[CONTROL_POINT_INDEX["chin_bottom"]] - centre)[1] < 0
    nearest = np.asarray(KDTree(mesh.vertices).query(points)[1])
    weights = np.zeros(len(mesh.vertices)) if blendshapes is None else jaw_weights(blendshapes, nearest)
    weights[weights < _MIN_JAW_WEIGHT] = 0.0
    weights[mesh.group_vertices(*RIGID_GROUPS)] = 0.0
    weights[mesh.group_vertices(*JAW_GROUPS)] = 1.0
    vertices = np.flatnonzero(weights)
    return Jaw(
        centre=centre,
        axis=axis if opens else -axis,
        vertices=vertices,
        weights=weights[vertices].astype(np.float32),
        weighted_offsets=((mesh.vertices[vertices] - centre) * weights[vertices, None]).astype(np.float32),
        point_weights=weights[nearest].astype(np.float32),
        weighted_point_offsets=((points - centre) * weights[nearest, None]).astype(np.float32),
    )
