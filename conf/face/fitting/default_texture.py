"""Paint for a face that has no picture of its own: plain skin, eyes with an iris, teeth, a dark mouth.

Without an iris nobody, and no tracker, sees where an eye looks. One small picture, made by
`tools/assets/default_texture.py`, holds an eye as seen along its axis, its distance from the middle the arc on the
eyeball, and four plain colours.
"""

from collections.abc import Mapping
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.rig_builder import EYES
from conf.face.mesh.mesh import Mesh

PICTURE = Path(str(files("conf"))) / "assets" / "plain.webp"
EYE_ARC = 2.6  # model cm on the eyeball from its front to the rim of the picture of the eye
# Places in the picture, u and v upwards: the middle of the eye and its rim's distance, the middles of the colours.
EYE_MIDDLE, EYE_RIM = np.array([0.25, 0.5]), np.array([0.245, 0.49])
COLOURS = {"skin": (0.625, 0.75), "teeth": (0.875, 0.75), "tongue": (0.625, 0.25), "mouth": (0.875, 0.25)}
_COLOUR_OF = {"teeth_upper": "teeth", "teeth_lower": "teeth", "tongue": "tongue", "mouth": "mouth"}


def apply_default_texture(mesh: Mesh, points: NDArray[np.float64], eyes: Mapping[str, NDArray[np.float64]], /) -> Mesh:
    """Return the mesh with the plain picture and texture coordinates for it; its own, if it has any, are lost.

    mesh : upright, in model centimetres, its groups named as those of the shipped head
    points : (n, 3) control points; eyes : group of an eyeball -> (3,) its centre
    """
    part = np.zeros(len(mesh.triangles), dtype=np.int64)
    names = ["skin", *(group for group in (*EYES, *_COLOUR_OF) if group in mesh.groups)]
    for number, name in enumerate(names[1:], start=1):
        part[mesh.groups[name]] = number
    keys, inverse = np.unique(mesh.triangles * len(names) + part[:, None], return_inverse=True)
    vertices, of_part = np.divmod(keys, len(names))
    uvs = np.empty((len(keys), 2))
    for number, name in enumerate(names):
        rows = of_part == number
        if name in eyes:
            uvs[rows] = _eye_places(mesh.vertices[vertices[rows]], eyes[name], points[CONTROL_POINT_INDEX[EYES[name]]])
        else:
            uvs[rows] = COLOURS[_COLOUR_OF.get(name, "skin")]
    return replace(
        mesh,
        uvs=uvs,
        render_vertices=vertices.astype(np.int32),
        render_triangles=inverse.reshape(-1, 3).astype(np.int32),
        texture=PICTURE,
    )


def _eye_places(
    vertices: NDArray[np.float64], centre: NDArray[np.float64], pupil: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return (k, 2) places in the picture for vertices (k, 3) of an eyeball."""
    radius = np.linalg.norm(pupil - centre)
    forward = (pupil - centre) / radius
    right = np.cross([0.0, 1.0, 0.0], forward)
    right /= np.linalg.norm(right)
    x, y, z = ((vertices - centre) @ np.stack([right, np.cross(forward, right), forward], axis=1)).T
    flat = np.hypot(x, y)
    share = np.minimum(np.arctan2(flat, z) * radius / EYE_ARC, 1.0) / np.maximum(flat, 1e-9)
    return np.asarray(EYE_MIDDLE + EYE_RIM * np.stack([x * share, y * share], axis=1))
