"""Put eyeballs into a face that has holes for its eyes and nothing in them."""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.rig_builder import EYES
from conf.face.formats.obj import RawMesh
from conf.face.mesh.mesh import Mesh, build_mesh
from conf.face.mesh.raycast import cast_front_rays

# Model centimetres, 6.4 between the pupils.
_RADIUS = 1.55  # as on eight heads that have eyeballs
_DEEP = 1.0  # behind the lids: what the viewer sees there is no eyeball and no closed lid
_BEHIND = 0.06  # the edges of the lids an eyeball lies
_RINGS, _COLUMNS = 14, 24
_REACH = np.radians(100.0)  # from its front an eyeball is made


def insert_eyeballs(mesh: Mesh, points: NDArray[np.float64], /) -> tuple[Mesh, NDArray[np.float64]]:
    """Return the mesh with an eyeball in each empty socket, and the points with the pupils on them.

    mesh, points : upright, in model centimetres; points (n, 3). New vertices come after those of the mesh.
    """
    points = points.copy()
    for pupil in EYES.values():
        lids = points[[CONTROL_POINT_INDEX[f"eyelid_{lid}_{pupil[-1]}"] for lid in ("upper", "lower")]]
        seen = cast_front_rays(lids[:, :2].mean(axis=0)[None], mesh.vertices, mesh.triangles).points[0, 2]
        if seen > lids[:, 2].mean() - _DEEP:  # nan is not
            continue
        centre = _centre(
            points[CONTROL_POINT_INDEX[pupil]],
            np.concatenate([lids, points[[CONTROL_POINT_INDEX[f"eye_outer_corner_{pupil[-1]}"]]]]),
        )
        points[CONTROL_POINT_INDEX[pupil]] = centre + np.array([0.0, 0.0, _RADIUS])
        mesh = _with_ball(mesh, centre, outwards=_faces_viewer(mesh, points))
    return mesh, points


def _centre(pupil: NDArray[np.float64], edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the centre (3,) of an eyeball behind a pupil that lies just behind the edges of the lids (k, 3)."""
    away = np.linalg.norm(edges[:, :2] - pupil[:2], axis=1)
    bulge = np.sqrt(np.maximum(_RADIUS**2 - away**2, 0.0))
    return np.array([*pupil[:2], float((edges[:, 2] - bulge).min()) - _BEHIND])


def _faces_viewer(mesh: Mesh, points: NDArray[np.float64]) -> bool:
    """Say whether the triangles seen from the front face outwards."""
    hits = cast_front_rays(points[:, :2], mesh.vertices, mesh.triangles).triangles
    corners = mesh.vertices[mesh.triangles[hits[hits >= 0]]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return bool((normals[:, 2] > 0).sum() * 2 >= len(normals))


def _with_ball(mesh: Mesh, centre: NDArray[np.float64], *, outwards: bool) -> Mesh:
    """Return the mesh with a round cap more, its triangles facing outwards or inwards as the mesh's do."""
    angle = np.linspace(0, _REACH, _RINGS + 1)[1:, None]
    around = np.arange(_COLUMNS) * 2 * np.pi / _COLUMNS
    rings = np.stack([np.sin(angle) * np.cos(around), np.sin(angle) * np.sin(around), np.cos(angle) + 0 * around], -1)
    ball = centre + _RADIUS * np.concatenate([[[0.0, 0.0, 1.0]], rings.reshape(-1, 3)])
    row = 1 + np.arange(_RINGS * _COLUMNS).reshape(_RINGS, _COLUMNS)
    turned = np.roll(row, -1, axis=1)
    a, b, c, d = row[:-1], row[1:], turned[1:], turned[:-1]
    fan = np.stack([np.zeros(_COLUMNS, np.int64), row[0], turned[0]], axis=-1)
    sides = [np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))]
    triangles = len(mesh.vertices) + np.concatenate([fan, *sides])
    if not outwards:
        triangles = triangles[:, ::-1]
    old = np.stack([mesh.triangles, mesh.render_triangles], axis=-1).astype(np.int64)
    new = np.stack([triangles, np.full_like(triangles, -1)], axis=-1)
    vertices, corners = np.concatenate([mesh.vertices, ball]), np.concatenate([old, new])
    return build_mesh(RawMesh(vertices, mesh.uvs, corners, mesh.groups, mesh.texture))
