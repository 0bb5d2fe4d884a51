"""Put the default head's teeth and tongue into a mouth that has none."""

from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, control_point_indices
from conf.face.default_head import DEFAULT_HEAD, default_points
from conf.face.mesh.editing import submesh
from conf.face.mesh.mesh import Mesh, load_mesh
from conf.face.mesh.raycast import cast_front_rays

GROUPS = ("teeth_upper", "teeth_lower", "tongue")
_SCALES = (0.75, 1.1)  # of the default head's teeth
_STEP, _STEPS = 0.15, 10  # cm by which the teeth are moved back, and how often, until the closed lips hide them
_COVER = (0.05, 0.3)  # cm of skin before the teeth: at the line of the lips, and at the roots, where it moves less
_MAX_VISIBLE = 0.02  # fraction of the vertices
_CORNERS = control_point_indices("inner_lip_corner")
_SEAM = [CONTROL_POINT_INDEX[f"inner_lip_{lip}_mid"] for lip in ("upper", "lower")]


def insert_teeth(mesh: Mesh, points: NDArray[np.float64], /, *, outwards: bool) -> Mesh:
    """Return the mesh with teeth and tongue behind the lips, in groups of their own.

    mesh, points : upright, in model centimetres; points (n, 3). New vertices come after those of the mesh.
    outwards : whether the mesh's triangles face outwards
    """
    teeth, default = _default_teeth(), default_points()
    scale = float(np.clip(np.ptp(points[_CORNERS, 0]) / np.ptp(default[_CORNERS, 0]), *_SCALES))
    seam = points[_SEAM].mean(axis=0)
    vertices = (teeth.vertices - default[_SEAM].mean(axis=0)) * scale + seam
    skin_depth = cast_front_rays(vertices[:, :2], mesh.vertices, mesh.triangles).points[:, 2]
    cover = np.interp(np.abs(vertices[:, 1] - seam[1]), [0.0, 1.0], _COVER)
    for _ in range(_STEPS):  # a miss, nan, hides nothing
        if np.mean(~(skin_depth > vertices[:, 2] + cover)) <= _MAX_VISIBLE:
            break
        vertices = vertices - [0.0, 0.0, _STEP]
    triangles, render_triangles = teeth.triangles, teeth.render_triangles
    if not outwards:
        triangles, render_triangles = triangles[:, ::-1], render_triangles[:, ::-1]
    materials, colours = mesh.extended_colours(len(triangles), len(vertices))
    return replace(
        mesh,
        triangle_materials=materials,
        vertex_colours=colours,
        vertices=np.concatenate([mesh.vertices, vertices]),
        triangles=np.concatenate([mesh.triangles, triangles + len(mesh.vertices)]).astype(np.int32),
        uvs=np.concatenate([mesh.uvs, np.zeros_like(teeth.uvs)]),
        render_vertices=np.concatenate([mesh.render_vertices, teeth.render_vertices + len(mesh.vertices)]).astype(
            np.int32
        ),
        render_triangles=np.concatenate([mesh.render_triangles, render_triangles + len(mesh.render_vertices)]).astype(
            np.int32
        ),
        groups=mesh.groups | {name: members + len(mesh.triangles) for name, members in teeth.groups.items()},
    )


@cache
def _default_teeth() -> Mesh:
    """Return teeth and tongue of the default head."""
    head = load_mesh(DEFAULT_HEAD)
    kept = np.zeros(len(head.triangles), dtype=np.bool_)
    for name in GROUPS:
        kept[head.groups[name]] = True
    return submesh(head, kept)
