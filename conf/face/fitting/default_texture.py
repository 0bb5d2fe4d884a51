"""Texture a face that has no image of its own: plain skin, eyes with an iris, teeth, a dark mouth.

Without an iris neither a viewer nor a tracker can tell the gaze. One small image, made by
`tools/assets/default_texture.py`, holds four plain colours and an eye as seen along its axis: the distance from the
image's eye centre is the arc length on the eyeball.
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

TEXTURE_FILE = Path(str(files("conf"))) / "assets" / "plain.webp"
EYE_ARC = 2.6  # cm on the eyeball from its front to the rim of the eye in the image
# Texture coordinates, u and v upwards: centre and radii of the eye, centres of the colours.
EYE_UV, EYE_UV_RADII = np.array([0.25, 0.5]), np.array([0.245, 0.49])
COLOUR_UVS = {"skin": (0.625, 0.75), "teeth": (0.875, 0.75), "tongue": (0.625, 0.25), "mouth": (0.875, 0.25)}
_GROUP_COLOURS = {"teeth_upper": "teeth", "teeth_lower": "teeth", "tongue": "tongue", "mouth": "mouth"}


def apply_default_texture(mesh: Mesh, points: NDArray[np.float64], eyes: Mapping[str, NDArray[np.float64]], /) -> Mesh:
    """Return the mesh with the default texture on all triangles without a material; their own coordinates are dropped.

    An eyeball, a tooth, the tongue and the inside of the mouth lose a material that is one plain colour.
    mesh : upright, in model centimetres, its groups named as those of the default head
    points : (n, 3) control points; eyes : group of an eyeball -> (3,) its centre
    """
    mesh = _without_plain_colours(mesh)
    is_default = mesh.materials_of_triangles() < 0
    part = np.zeros(len(mesh.triangles), dtype=np.int64)
    names = ["skin", *(group for group in (*EYES, *_GROUP_COLOURS) if group in mesh.groups)]
    for number, name in enumerate(names[1:], start=1):
        part[mesh.groups[name]] = number
    keys, inverse = np.unique(mesh.triangles[is_default] * len(names) + part[is_default, None], return_inverse=True)
    vertices, vertex_parts = np.divmod(keys, len(names))
    uvs = np.empty((len(keys), 2))
    for number, name in enumerate(names):
        rows = vertex_parts == number
        if name in eyes:
            uvs[rows] = _eye_uvs(mesh.vertices[vertices[rows]], eyes[name], points[CONTROL_POINT_INDEX[EYES[name]]])
        else:
            uvs[rows] = COLOUR_UVS[_GROUP_COLOURS.get(name, "skin")]
    kept, kept_triangles = np.unique(mesh.render_triangles[~is_default], return_inverse=True)
    render_triangles = np.empty((len(mesh.triangles), 3), np.int32)
    render_triangles[is_default] = inverse.reshape(-1, 3)
    render_triangles[~is_default] = kept_triangles.reshape(-1, 3) + len(keys)
    return replace(
        mesh,
        uvs=np.concatenate([uvs, mesh.uvs[kept]]),
        render_vertices=np.concatenate([vertices, mesh.render_vertices[kept]]).astype(np.int32),
        render_triangles=render_triangles,
        texture=TEXTURE_FILE,
    )


def _without_plain_colours(mesh: Mesh) -> Mesh:
    """Return the mesh without the materials of eyes and mouth that are one colour for the whole part."""
    if mesh.triangle_materials is None or mesh.vertex_colours is not None:
        return mesh
    numbers = mesh.triangle_materials.copy()
    for name in (*EYES, *_GROUP_COLOURS):
        used = np.unique(numbers[mesh.groups[name]]) if name in mesh.groups else np.empty(0, np.int32)
        if len(used) == 1 and used[0] >= 0 and mesh.materials[used[0]].image is None:
            numbers[mesh.groups[name]] = -1
    return replace(mesh, triangle_materials=numbers)


def _eye_uvs(
    vertices: NDArray[np.float64], centre: NDArray[np.float64], pupil: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the (k, 2) texture coordinates of vertices (k, 3) of an eyeball."""
    radius = np.linalg.norm(pupil - centre)
    forward = (pupil - centre) / radius
    right = np.cross([0.0, 1.0, 0.0], forward)
    right /= np.linalg.norm(right)
    x, y, z = ((vertices - centre) @ np.stack([right, np.cross(forward, right), forward], axis=1)).T
    off_axis = np.hypot(x, y)
    scale = np.minimum(np.arctan2(off_axis, z) * radius / EYE_ARC, 1.0) / np.maximum(off_axis, 1e-9)
    return np.asarray(EYE_UV + EYE_UV_RADII * np.stack([x * scale, y * scale], axis=1))
