"""Keep the eyes of a textured skin: the eyeballs behind the lids that are cut open show what was painted there.

Strategy. An eye looks alike in all directions from its pupil, but lids cover much of it and leave the white on the
outer side. So each vertex of an eyeball gets the texture coordinates that the skin has at the same distance from the
pupil on the level line towards the outer corner: the iris is round whatever the lids covered, also after a glance.
A scan with closed eyes shows skin there: it gets the default eyes.
"""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.rig_builder import EYES
from conf.face.formats.mtl import MeshMaterial
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.raycast import cast_front_rays

_MAX_DEPTH = 1.0  # cm from the lids to the surface between them: what is deeper is a socket
_TO_CORNER = 0.75  # of the distance from the pupil to the outer corner: beyond it the skin shows the corner
_SAMPLES = 24  # of the image from the pupil towards the corner
_CHEEK = 1.2  # cm below the lower lid, where the skin is compared with the eye
_MAX_PUPIL = 0.6  # brightness of a pupil or an iris, relative to the skin
_MAX_WHITE = 0.6, 0.9  # saturation of the white of an eye relative to the skin, and its least brightness


def keep_painted_eyes(mesh: Mesh, painted: Mesh, points: NDArray[np.float64], eyes: Iterable[str], /) -> Mesh:
    """Return the mesh with the material of the skin on eyeballs without a material, where the skin shows eyes.

    mesh : with eyeballs in the groups `eyes`; painted : the same face before its eyes were cut open
    points : (n, 3) control points; all upright, in model centimetres
    """
    if mesh.triangle_materials is None:
        return mesh
    for group in eyes:
        rows = mesh.groups[group]
        if (mesh.triangle_materials[rows] < 0).all():
            mesh = _keep_eye(mesh, painted, points, rows, side=EYES[group][-1])
    return mesh


def image_between_lids(mesh: Mesh, points: NDArray[np.float64], side: str, /) -> int:
    """Return the index of the material with an image that is visible between the lids of one eye.

    -1 if it has no image, and for a socket, which is deeper.
    """
    middle = points[[CONTROL_POINT_INDEX[f"eyelid_{lid}_{side}"] for lid in ("upper", "lower")]].mean(axis=0)
    hit = cast_front_rays(middle[None, :2], mesh.vertices, mesh.triangles)
    if not hit.points[0, 2] > middle[2] - _MAX_DEPTH:  # also True for nan, a miss
        return -1
    number = int(mesh.materials_of_triangles()[hit.triangles[0]])
    return number if number >= 0 and mesh.materials[number].image is not None else -1


def _keep_eye(mesh: Mesh, painted: Mesh, points: NDArray[np.float64], rows: NDArray[np.int64], *, side: str) -> Mesh:
    number = image_between_lids(painted, points, side)
    if number < 0 or not _shows_eye(painted, points, number, side=side):
        return mesh
    outer, pupil = points[[CONTROL_POINT_INDEX[f"{name}_{side}"] for name in ("eye_outer_corner", "pupil")], :2]
    vertices, corners = np.unique(mesh.triangles[rows], return_inverse=True)
    distance = np.linalg.norm(mesh.vertices[vertices, :2] - pupil, axis=1)
    distance = np.minimum(distance, _TO_CORNER * abs(outer[0] - pupil[0]))
    across = pupil[0] + np.sign(outer[0] - pupil[0]) * distance
    uvs = _uvs_at(painted, np.stack([across, np.full_like(across, pupil[1])], axis=1))
    render_triangles, materials = mesh.render_triangles.copy(), mesh.materials_of_triangles().copy()
    render_triangles[rows] = len(mesh.render_vertices) + corners.reshape(-1, 3)
    materials[rows] = number
    return replace(
        mesh,
        uvs=np.concatenate([mesh.uvs, uvs]),
        render_vertices=np.concatenate([mesh.render_vertices, vertices]).astype(np.int32),
        render_triangles=render_triangles,
        triangle_materials=materials,
    )


def _shows_eye(painted: Mesh, points: NDArray[np.float64], number: int, *, side: str) -> bool:
    """Tell whether the image shows something as dark as an iris and something as pale as the white of an eye."""
    outer, pupil, lid = points[
        [CONTROL_POINT_INDEX[f"{name}_{side}"] for name in ("eye_outer_corner", "pupil", "eyelid_lower")], :2
    ]
    across = np.linspace(0, _TO_CORNER, _SAMPLES)[:, None] * [outer[0] - pupil[0], 0.0] + pupil
    image = _read(painted.materials[number])
    if image is None:
        return True
    uvs = _uvs_at(painted, np.concatenate([across, [lid - [0.0, _CHEEK]]]))
    height, width = image.shape[:2]
    columns = np.floor(uvs[:, 0] % 1 * width).astype(int) % width
    rows = np.floor((1 - uvs[:, 1]) % 1 * height).astype(int) % height
    colours = image[rows, columns, :3].astype(np.float64)
    bright = colours.max(axis=1) + 1.0
    saturation = 1 - colours.min(axis=1) / bright
    is_dark = bright[:-1] < _MAX_PUPIL * bright[-1]
    is_pale = (saturation[:-1] < _MAX_WHITE[0] * saturation[-1]) & (bright[:-1] > _MAX_WHITE[1] * bright[-1])
    return bool(is_dark.any() and is_pale.any())


def _read(material: MeshMaterial) -> NDArray[np.uint8] | None:
    """Return the (h, w, 3 or 4) image of a material, the top row first; None if its file is not one."""
    if not isinstance(material.image, Path):
        return material.image
    import cv2  # a few faces only need it

    try:
        image = cv2.imdecode(np.frombuffer(material.image.read_bytes(), np.uint8), cv2.IMREAD_COLOR)
    except (OSError, cv2.error):
        return None
    return None if image is None else np.asarray(image, np.uint8)


def _uvs_at(mesh: Mesh, positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (k, 2) texture coordinates of the front of a mesh at positions (k, 2)."""
    hits = cast_front_rays(positions, mesh.vertices, mesh.triangles)
    is_hit = hits.triangles >= 0
    found = hits.triangles[is_hit]
    a, b, c = (mesh.vertices[mesh.triangles[found, corner], :2] for corner in range(3))
    weights = np.stack([_double_area(p, q, positions[is_hit]) for p, q in ((b, c), (c, a), (a, b))], axis=1)
    weights /= weights.sum(axis=1, keepdims=True)
    uvs = np.empty((len(positions), 2))
    uvs[is_hit] = np.einsum("kc,kcd->kd", weights, mesh.uvs[mesh.render_triangles[found]])
    if not is_hit.all():
        uvs[~is_hit] = uvs[is_hit].mean(axis=0) if is_hit.any() else 0.0
    return uvs


def _double_area(p: NDArray[np.float64], q: NDArray[np.float64], r: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (k,) twice the signed area of triangles with corners p, q, r, (k, 2) each."""
    return np.asarray((q[:, 0] - p[:, 0]) * (r[:, 1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (r[:, 0] - p[:, 0]))
