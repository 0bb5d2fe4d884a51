"""rig.json: which parts of a head are rigid and what they turn about."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError
from conf.face.deformation.blendshapes import Blendshapes
from conf.face.deformation.rig import Rig
from conf.face.deformation.rig_builder import EYES, RigJoints, build_rig
from conf.face.formats.text import check_file
from conf.face.mesh.mesh import Mesh

_MAX_BYTES = 1 << 20
_MAX_COORDINATE = 1e6


def load_rig(path: Path, mesh: Mesh, points: NDArray[np.float64], shapes: Blendshapes | None = None, /) -> Rig:
    """Read the rig of a mesh with the groups eye_l, eye_r, teeth_upper, teeth_lower and tongue.

    points : (n, 3) control points, model units
    shapes : sculpted shapes of the mesh: they tell how far the skin follows the jaw
    Raises FileFormatError if the file is not a rig.
    """
    return build_rig(mesh, points, read_joints(path), shapes)


def read_joints(path: Path, /) -> RigJoints:
    """Read what the parts of a head turn about.

    Raises FileFormatError if the file is not a rig.
    """
    check_file(path, max_bytes=_MAX_BYTES)
    try:
        rig = json.loads(path.read_bytes())
        return RigJoints(
            eyes={name: _numbers(rig[name]["centre"], (3,)) for name in EYES if name in rig},
            hinge=(_numbers(rig["jaw"]["centre"], (3,)), _numbers(rig["jaw"]["axis"], (3,))) if "jaw" in rig else None,
            anchors=_numbers(rig.get("anchors", []), (-1, 3)),
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise FileFormatError(path, None, "expected a rig: eyes, jaw and anchors with their coordinates") from error


def _numbers(value: Any, shape: tuple[int, ...]) -> NDArray[np.float64]:
    array = np.array(value, dtype=np.float64).reshape(shape)
    if not np.isfinite(array).all() or np.abs(array).max(initial=0.0) > _MAX_COORDINATE:
        raise ValueError("a coordinate out of range")
    return array
