"""rig.json: which parts of a head are rigid and what they turn about."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from conf.errors import FileFormatError
from conf.face.control_points import INDEX
from conf.face.learned import jaw_shares
from conf.face.mesh import Mesh
from conf.face.rig import Eye, Jaw, Rig
from conf.face.shapes import Shapes
from conf.face.text_lines import check_file

_MAX_BYTES = 1 << 20
_MAX_COORDINATE = 1e6
_LID_REACH = 1.35  # skin this many eyeball radii from the centre may come to rest on the eyeball
_LID_MARGIN_CM = 0.03  # a closed lid stays this far off the eyeball
_LEAST_SHARE = 0.02  # skin that follows the jaw less does not follow it
_EYES = {"eye_l": "pupil_l", "eye_r": "pupil_r"}
_JAW_GROUPS = ("teeth_lower", "tongue")
_RIGID_GROUPS = ("teeth_upper", *_JAW_GROUPS, *_EYES)


def load_rig(path: Path, mesh: Mesh, points: NDArray[np.float64], shapes: Shapes | None = None, /) -> Rig:
    """Read the rig of a mesh with the groups eye_l, eye_r, teeth_upper, teeth_lower and tongue.

    points : (n, 3) control points, model units
    shapes : sculpted shapes of the mesh: they tell how far the skin follows the jaw
    Raises FileFormatError if the file is not a rig.
    """
    check_file(path, max_bytes=_MAX_BYTES)
    try:
        rig = json.loads(path.read_bytes())
        eyes = {name: _numbers(rig[name]["centre"], (3,)) for name in _EYES if name in rig}
        hinge = [_numbers(rig["jaw"][name], (3,)) for name in ("centre", "axis")] if "jaw" in rig else None
        anchors = _numbers(rig.get("anchors", []), (-1, 3))
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise FileFormatError(path, None, "expected a rig: eyes, jaw and anchors with their coordinates") from error
    rigid = mesh.group_vertices(*_RIGID_GROUPS)
    skin = np.setdiff1d(np.arange(len(mesh.vertices)), rigid)
    return Rig(
        eyes=tuple(_eye(mesh, name, centre, skin) for name, centre in eyes.items()),
        jaw=_jaw(hinge, mesh, points, shapes) if hinge else None,
        anchors=anchors,
        rigid=rigid,
    )


def _numbers(value: Any, shape: tuple[int, ...]) -> NDArray[np.float64]:
    array = np.array(value, dtype=np.float64).reshape(shape)
    if not np.isfinite(array).all() or np.abs(array).max(initial=0.0) > _MAX_COORDINATE:
        raise ValueError("a coordinate out of range")
    return array


def _eye(mesh: Mesh, name: str, centre: NDArray[np.float64], skin: NDArray[np.int64]) -> Eye:
    ball = mesh.group_vertices(name)
    radius = np.linalg.norm(mesh.vertices[ball] - centre, axis=1).max(initial=0.0)
    distance = np.linalg.norm(mesh.vertices[skin] - centre, axis=1)
    near = distance < _LID_REACH * radius
    return Eye(
        centre=centre,
        pupil=INDEX[_EYES[name]],
        vertices=ball,
        lids=skin[near],
        # What is inside the eyeball at rest may stay as deep, no deeper.
        clearance=np.minimum(distance[near], radius + _LID_MARGIN_CM).astype(np.float32),
    )


def _jaw(hinge: list[NDArray[np.float64]], mesh: Mesh, points: NDArray[np.float64], shapes: Shapes | None) -> Jaw:
    centre, axis = hinge
    axis = axis / max(float(np.linalg.norm(axis)), 1e-12)
    # Whichever way the file's axis points: opening moves the chin down.
    opens = np.cross(axis, points[INDEX["chin_bottom"]] - centre)[1] < 0
    nearest = np.asarray(KDTree(mesh.vertices).query(points)[1])
    shares = np.zeros(len(mesh.vertices)) if shapes is None else jaw_shares(shapes, nearest)
    shares[shares < _LEAST_SHARE] = 0.0
    shares[mesh.group_vertices(*_RIGID_GROUPS)] = 0.0
    shares[mesh.group_vertices(*_JAW_GROUPS)] = 1.0
    vertices = np.flatnonzero(shares)
    arms = (mesh.vertices - centre) * shares[:, None]
    point_arms = (points - centre) * shares[nearest][:, None]
    return Jaw(
        centre=centre,
        axis=axis if opens else -axis,
        vertices=vertices,
        shares=shares[vertices].astype(np.float32),
        arms=arms[vertices].astype(np.float32),
        point_shares=shares[nearest].astype(np.float32),
        point_arms=point_arms.astype(np.float32),
    )
