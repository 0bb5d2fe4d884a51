"""Keep the eyes of a textured skin: the eyeballs behind the lids that are cut open show what was painted there.

Strategy. An eye looks alike in all directions from its pupil, but lids cover much of it and leave the white on the
outer side. So each vertex of an eyeball gets the texture coordinates that the skin has at the same distance from the
pupil on the level line towards the outer corner: the iris is round whatever the lids covered, also after a glance.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.rig_builder import EYES
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.raycast import cast_front_rays

_MAX_DEPTH = 1.0  # cm from the lids to the surface between them: what is deeper is a socket
_TO_CORNER = 0.75  # of the distance from the pupil to the outer corner: beyond it the skin shows the corner


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
    if number < 0:
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
