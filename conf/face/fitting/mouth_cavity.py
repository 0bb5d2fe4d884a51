"""Close the mouth of a face that has no inside: a cavity behind the hole between the lips.

Strategy. The border of the hole is a closed path along open edges. Its leftmost and rightmost vertices divide it into
the upper and the lower lip's rim; each is extruded backwards, and the two halves overlap at the back.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, control_point_indices
from conf.face.mesh.editing import grid_triangles
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.surface_graph import SurfaceGraph, component_labels, triangle_edges

# Model centimetres, 6.4 between the pupils.
_PROFILE = np.array(
    [[0.08, 0], [0.35, 0.4], [0.7, 1.0], [1.5, 1.5], [3.0, 1.6], [4.5, 1.0], [5, -0.4]]
)  # depth, height
_NARROWING = np.array([1.0, 0.98, 0.97, 0.92, 0.85, 0.75, 0.75])  # width along the profile, of the mouth's
_CORNER_DEPTH = 0.35  # depth in the corners of the mouth, of the depth in the middle
_MAX_OFFSET = np.array([1.0, 1.5, 2.5])  # of the hole's border beyond the corners, from the line of the lips, behind it
_MIN_WIDTH = 0.5  # of the hole, of the distance of the inner corners of the lips
_SKIN_TOLERANCE = 0.3  # by which the skin may be farther than another component
_LIP_REACH = 6.0  # along the surface from the outer edge of a lip
_MOUTH = "mouth"
_OUTER_LIPS = [control_point_indices(f"outer_lip_{lip}") for lip in ("upper", "lower")]
_CORNERS = control_point_indices("inner_lip_corner")
_SEAM = [CONTROL_POINT_INDEX[f"inner_lip_{lip}_mid"] for lip in ("upper", "lower")]


def add_mouth_cavity(mesh: Mesh, points: NDArray[np.float64], /) -> Mesh:
    """Return the mesh with a cavity in the group "mouth" behind a hole between the lips; the mesh if there is none.

    mesh, points : upright, in model centimetres; points (n, 3). New vertices come after those of the mesh.
    """
    border = _find_border(mesh, points)
    if border is None:
        return mesh
    x = mesh.vertices[border, 0]
    border = np.roll(border, -int(x.argmin()))
    turn = int(mesh.vertices[border, 0].argmax())
    paths = border[: turn + 1], np.append(border[turn:], border[0])[::-1]  # both from the right to the left
    to_upper, to_lower = _lip_distances(mesh, points)  # closed lips may overlap, so that heights do not tell them apart
    upper = int(np.argmin([np.mean(to_upper[path] - to_lower[path]) for path in paths]))
    # The border runs along with its triangles; the cavity's triangles run against it.
    for number, path in enumerate(paths):
        mesh = _extrude(mesh, path, up=1.0 if number == upper else -1.0, reverse=number == 0)
    return mesh


def _lip_distances(mesh: Mesh, points: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return the (V,) distances along the surface from the outer edges of the upper and of the lower lip."""
    surface = SurfaceGraph(mesh.vertices, mesh.triangles)
    seeds = (surface.nearest_vertices(points[lip], tolerance=_SKIN_TOLERANCE) for lip in _OUTER_LIPS)
    return [surface.distances(lip, limit=_LIP_REACH) for lip in seeds]


def _find_border(mesh: Mesh, points: NDArray[np.float64]) -> NDArray[np.int64] | None:
    """Return the (k,) vertices around the hole between the lips, in the order of the triangles beside it."""
    half_edges = triangle_edges(mesh.triangles).astype(np.int64)
    count = len(mesh.vertices)
    keys = half_edges.min(axis=1) * count + half_edges.max(axis=1)
    _, index, counts = np.unique(keys, return_index=True, return_counts=True)
    open_edges = half_edges[index[counts == 1]]
    if not len(open_edges):
        return None
    seam, width = points[_SEAM].mean(axis=0), float(np.ptp(points[_CORNERS, 0]))
    limit = np.array([width / 2, 0.0, 0.0]) + _MAX_OFFSET
    labels = component_labels(open_edges, count)[open_edges[:, 0]]
    is_far = (np.abs(mesh.vertices[open_edges[:, 0]] - seam) > limit).any(axis=1)
    is_near = ~np.isin(labels, labels[is_far])
    open_edges, labels = open_edges[is_near], labels[is_near]
    found: tuple[float, NDArray[np.int64]] | None = None
    for label in np.unique(labels):
        loop = open_edges[labels == label]
        size = float(np.ptp(mesh.vertices[loop[:, 0], 0]))
        if size < _MIN_WIDTH * width:
            continue
        ordered = _walk(loop)
        if ordered is not None and (found is None or size > found[0]):
            found = size, ordered
    return None if found is None else found[1]


def _walk(edges: NDArray[np.int64]) -> NDArray[np.int64] | None:
    """Return the vertices of directed edges (k, 2) that form one closed path, in its order; None if they do not."""
    following = dict(edges.tolist())
    if len(following) != len(edges):
        return None
    path = [int(edges[0, 0])]
    while len(path) <= len(edges):
        after = following.get(path[-1])
        if after is None:
            return None
        if after == path[0]:
            return np.array(path, dtype=np.int64) if len(path) == len(edges) else None
        path.append(after)
    return None


def _extrude(mesh: Mesh, rim: NDArray[np.int64], *, up: float, reverse: bool) -> Mesh:
    """Return the mesh with half a cavity behind a rim (k,) that runs from right to left. up : 1 upper half, -1 lower"""
    positions = mesh.vertices[rim]
    centre, half_width = (positions[0, 0] + positions[-1, 0]) / 2, max(np.ptp(positions[:, 0]) / 2, 1e-9)
    t = (positions[:, 0] - centre) / half_width
    height = np.sqrt(np.maximum(1 - t**2, 0.0))[:, None]  # 0 in the corners of the mouth, 1 in the middle
    back, rise = _PROFILE.T
    x = centre + half_width * t[:, None] * _NARROWING
    y = positions[:, 1:2] + height * rise * up
    z = positions[:, 2:3] - (_CORNER_DEPTH + (1 - _CORNER_DEPTH) * height) * back
    added = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    grid = np.column_stack([rim, len(mesh.vertices) + np.arange(x.size).reshape(x.shape)])
    triangles = grid_triangles(grid)
    if reverse:
        triangles = triangles[:, ::-1]
    # The cavity has the texture coordinates of the rim: the colour of the lips, which the mouth's shader darkens.
    render_of = np.zeros(len(mesh.vertices), dtype=np.int64)
    render_of[mesh.render_vertices] = np.arange(len(mesh.render_vertices))
    render_grid = len(mesh.render_vertices) + np.arange(grid.size).reshape(grid.shape)
    to_render = np.zeros(len(mesh.vertices) + len(added), dtype=np.int64)
    to_render[grid] = render_grid
    numbers = len(mesh.triangles) + np.arange(len(triangles))
    materials, colours = mesh.extended_colours(len(triangles), len(added))
    return replace(
        mesh,
        triangle_materials=materials,
        vertex_colours=colours,
        vertices=np.concatenate([mesh.vertices, added]),
        triangles=np.concatenate([mesh.triangles, triangles]).astype(np.int32),
        uvs=np.concatenate([mesh.uvs, mesh.uvs[render_of[rim]].repeat(grid.shape[1], axis=0)]),
        render_vertices=np.concatenate([mesh.render_vertices, grid.ravel()]).astype(np.int32),
        render_triangles=np.concatenate([mesh.render_triangles, to_render[triangles]]).astype(np.int32),
        groups=mesh.groups | {_MOUTH: np.concatenate([mesh.groups.get(_MOUTH, numbers[:0]), numbers])},
    )
