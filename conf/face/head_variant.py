"""Heads with the topology of the default head: what they have of their own is read from one NPZ file.

Vertices, hair, control points and joints are in the file; triangles and texture coordinates of all other parts are the
default head's. Its blendshapes serve too, turned and scaled.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.deformation.blendshapes import READ_ERRORS, Blendshapes
from conf.face.deformation.rig_builder import RigJoints, parse_joints
from conf.face.formats.obj import RawMesh
from conf.face.mesh.mesh import Mesh, build_mesh

_HAIR = "hair"
_STEPS = 65535  # of a coordinate between its extremes
_TEXTURE_SUFFIX = ".webp"


@dataclass(frozen=True)
class HeadVariant:
    """A head before its operator is built.

    points : (n, 3) control points, model centimetres
    """

    mesh: Mesh
    points: NDArray[np.float64]
    joints: RigJoints
    blendshapes: Blendshapes


def read_head_variant(path: Path, default: Mesh, shapes: Blendshapes, /) -> HeadVariant:
    """Read a head made by tools/assets/build_head.py.

    default, shapes : the default head and its blendshapes
    Raises FileFormatError if the file is missing or is not of this default head.
    """
    try:
        with path.open("rb") as file, np.load(file) as arrays:
            return _variant(path, arrays, default, shapes)
    except READ_ERRORS as error:
        raise FileFormatError(path, None, "expected a head of this version: install conf again") from error


def _variant(path: Path, arrays: Any, default: Mesh, shapes: Blendshapes) -> HeadVariant:
    low, high = arrays["bounds"].astype(np.float64)
    steps = np.cumsum(arrays["vertices"], axis=0, dtype=np.uint16)  # differences modulo 2^16
    vertices = low + steps / _STEPS * (high - low)
    is_hair = np.zeros(len(default.triangles), np.bool_)
    is_hair[default.groups[_HAIR]] = True
    shared = int(default.triangles[~is_hair].max()) + 1
    corners = np.stack([default.triangles, default.render_triangles], axis=-1).astype(np.int64)[~is_hair]
    hair = _split_quads(arrays["hair"].astype(np.int64)) + np.array([shared, len(default.uvs)])
    renumber = np.cumsum(~is_hair) - 1
    groups = {name: renumber[triangles] for name, triangles in default.groups.items() if name != _HAIR}
    if len(hair):
        groups[_HAIR] = np.arange(len(hair)) + len(corners)
    raw = RawMesh(
        positions=vertices,
        corners=np.concatenate([corners, hair]),
        uvs=np.concatenate([default.uvs, arrays["hair_uvs"] / _STEPS]),
        groups=groups,
        texture=path.with_suffix(_TEXTURE_SUFFIX),
    )
    offsets = np.zeros((len(shapes.names), len(vertices), 3), np.float32)
    offsets[:, :shared] = shapes.offsets[:, :shared] @ arrays["turn"]
    offsets *= arrays["scales"][:, None, None]
    points = arrays["points"].astype(np.float64).reshape(CONTROL_POINT_COUNT, 3)
    return HeadVariant(
        build_mesh(raw), points, parse_joints(arrays["rig"].tobytes()), Blendshapes(shapes.names, offsets)
    )


def _split_quads(corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the (F, 3, 2) corners of triangles for (Q, 4, 2) corners of quads, in the order that hair is drawn in."""
    return corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 2)
