"""Add eyeballs to a face with empty eye sockets."""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.eyelid_helpers import HELPER_LIDS, PARABOLA_WEIGHTS
from conf.face.deformation.rig_builder import EYES
from conf.face.formats.obj import RawMesh
from conf.face.mesh.editing import grid_triangles, with_colours_of
from conf.face.mesh.mesh import Mesh, build_mesh
from conf.face.mesh.raycast import cast_front_rays, faces_viewer

# Model centimetres, 6.4 between the pupils.
_RADIUS = 1.55  # as on eight heads that have eyeballs
_EMPTY_DEPTH = 1.0  # behind the lids: what is visible deeper than this is neither an eyeball nor a closed lid
_RIM_OFFSET, _RIM_DEPTH = 0.1, 0.5  # from a lid's parabola outwards, and from its depth to the skin there
_LID_GAP = 0.06  # from the edges of the lids back to the eyeball
_RINGS, _COLUMNS = 14, 24
_CAP_ANGLE = np.radians(100.0)  # from the front of the eyeball to the rim of the cap that is made of it


def insert_eyeballs(mesh: Mesh, points: NDArray[np.float64], /) -> tuple[Mesh, NDArray[np.float64]]:
    """Return the mesh with an eyeball in each empty socket, and the points with the pupils on them.

    mesh, points : upright, in model centimetres; points (n, 3). New vertices come after those of the mesh.
    """
    points = points.copy()
    for pupil in EYES.values():
        side, pupil_row = pupil[-1], CONTROL_POINT_INDEX[pupil]
        names = ("eyelid_upper", "eyelid_lower", "eye_outer_corner")
        edges = points[[CONTROL_POINT_INDEX[f"{name}_{side}"] for name in names]]
        lids = edges[:2]
        depth = cast_front_rays(lids[:, :2].mean(axis=0)[None], mesh.vertices, mesh.triangles).points[0, 2]
        if depth > lids[:, 2].mean() - _EMPTY_DEPTH:  # False for nan, a miss
            continue
        centre = _eyeball_centre(points[pupil_row], np.concatenate([edges, _rim(mesh, points, lids)]))
        points[pupil_row] = centre + np.array([0.0, 0.0, _RADIUS])
        mesh = _add_eyeball(mesh, centre, outwards=faces_viewer(points[:, :2], mesh.vertices, mesh.triangles))
    return mesh, points


def _rim(mesh: Mesh, points: NDArray[np.float64], lids: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (k, 3) skin just outside the edges of two lids, (2, 3), along their width."""
    rows = [np.linalg.norm(points[lid] - lids, axis=1).min() == 0 for lid in HELPER_LIDS]
    curve = (PARABOLA_WEIGHTS @ points)[rows]
    middle = lids[:, :2].mean(axis=0)
    outside = curve[:, :2] + _RIM_OFFSET * np.sign(curve[:, 1:2] - middle[1]) * [0.0, 1.0]
    hits = cast_front_rays(outside, mesh.vertices, mesh.triangles).points
    return np.asarray(hits[np.abs(hits[:, 2] - curve[:, 2]) < _RIM_DEPTH])  # False for nan, a miss


def _eyeball_centre(pupil: NDArray[np.float64], edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the centre (3,) of an eyeball behind a pupil, its surface just behind the edges of the lids (k, 3)."""
    distance = np.linalg.norm(edges[:, :2] - pupil[:2], axis=1)
    bulge = np.sqrt(np.maximum(_RADIUS**2 - distance**2, 0.0))
    return np.array([*pupil[:2], float((edges[:, 2] - bulge).min()) - _LID_GAP])


def _add_eyeball(mesh: Mesh, centre: NDArray[np.float64], *, outwards: bool) -> Mesh:
    """Return the mesh with a spherical cap added, its triangles facing outwards or inwards as the mesh's do."""
    polar = np.linspace(0, _CAP_ANGLE, _RINGS + 1)[1:, None]
    azimuth = np.arange(_COLUMNS) * 2 * np.pi / _COLUMNS
    x, y = np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth)
    rings = np.stack([x, y, np.cos(polar) + 0 * azimuth], -1)
    ball = centre + _RADIUS * np.concatenate([[[0.0, 0.0, 1.0]], rings.reshape(-1, 3)])
    grid = 1 + np.arange(_RINGS * _COLUMNS).reshape(_RINGS, _COLUMNS)
    grid = np.column_stack([grid, grid[:, 0]])
    fan = np.stack([np.zeros(_COLUMNS, np.int64), grid[0, :-1], grid[0, 1:]], axis=-1)
    triangles = len(mesh.vertices) + np.concatenate([fan, grid_triangles(grid)])
    if not outwards:
        triangles = triangles[:, ::-1]
    old = np.stack([mesh.triangles, mesh.render_triangles], axis=-1).astype(np.int64)
    new = np.stack([triangles, np.full_like(triangles, -1)], axis=-1)
    vertices, corners = np.concatenate([mesh.vertices, ball]), np.concatenate([old, new])
    raw = RawMesh(vertices, mesh.uvs, corners, mesh.groups, mesh.texture)
    return build_mesh(with_colours_of(raw, mesh))
