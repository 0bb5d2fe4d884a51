"""Cut a closed mouth open: split the mesh between the lips and add a cavity behind them.

Strategy. On many meshes the lips are one surface: when the jaw opens, skin is stretched over the mouth. The line
between the lips is known from the inner lip points. Every edge of the surface that crosses it is cut, the triangles
there are split, and each new vertex is created twice, once for either lip. The rim is extruded backwards to a cavity,
so that an open mouth shows its inside and not the back of the head.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, LOWER_LIP_EDGE, UPPER_LIP_EDGE
from conf.face.formats.obj import RawMesh
from conf.face.mesh.editing import grid_triangles, with_colours_of
from conf.face.mesh.mesh import Mesh, build_mesh
from conf.face.mesh.surface_graph import SurfaceGraph, triangle_edges
from conf.face.mesh.winding import triangle_normals

# Distance from lip to lip along the surface over the direct distance across the lips: measured 1.0 and 1.05 where the
# lips are one surface, 1.76 to 2.98 on ninety heads with open lips.
_OPEN_RATIO = 1.5
# Model centimetres, 6.4 between the pupils.
_SKIN_TOLERANCE = 0.3  # by which the skin may be farther than another component
_CUT_DISTANCE = 1.6  # along the skin from the line, within which triangles may be cut
_LINE_TOLERANCE = 1e-3  # vertices nearer to the line count as the upper lip's
_MIN_EDGES = 3  # fewer are not cut
_MOUTH = "mouth"
# Profile of the cavity from the upper lip to the lower: depth, and height relative to the line.
_BAG_PROFILE = np.array(
    # The narrow first ring keeps the cavity out of the vertex normals of the lips.
    [[0.08, 0], [0.5, 0.15], [1.5, 0.7], [3.0, 0.9], [4.0, 0], [3.0, -0.9], [1.5, -0.7], [0.5, -0.15], [0.08, 0]]
)
_NARROWING = np.array([1.0, 0.97, 0.92, 0.85, 0.75, 0.85, 0.92, 0.97, 1.0])  # width along the profile, of the mouth's
_CORNER_DEPTH = 0.35  # depth in the corners of the mouth, of the depth in the middle
_LIP_PROFILE = [
    CONTROL_POINT_INDEX[f"{name}_mid"]
    for name in ("outer_lip_upper", "inner_lip_upper", "inner_lip_lower", "outer_lip_lower")
]


def has_open_lips(points: NDArray[np.float64], surface: SurfaceGraph, /) -> bool:
    """Tell whether the path along the surface from lip to lip is longer than the one across the lips.

    points : (n, 3) control points in centimetres, about 6.4 between the pupils
    """
    profile = points[_LIP_PROFILE]
    upper, lower = surface.nearest_vertices(profile[[0, -1]], tolerance=_SKIN_TOLERANCE)
    limit = _OPEN_RATIO * float(np.linalg.norm(np.diff(profile, axis=0), axis=1).sum())
    return bool(surface.distances(np.array([upper]), limit=limit)[lower] >= limit)


def cut_lips(mesh: Mesh, points: NDArray[np.float64], surface: SurfaceGraph, /) -> Mesh:
    """Return the mesh cut between its lips, with a cavity in the group "mouth"; the mesh itself if nothing can be cut.

    mesh, points, surface : upright, in model centimetres; points (n, 3)
    New vertices come after those of the mesh.
    """
    line = (points[UPPER_LIP_EDGE] + points[LOWER_LIP_EDGE]) / 2
    line = line[np.argsort(line[:, 0])]
    seeds = surface.nearest_vertices(points[[*UPPER_LIP_EDGE, *LOWER_LIP_EDGE]], tolerance=_SKIN_TOLERANCE)
    near_vertices = np.asarray(surface.distances(seeds, limit=_CUT_DISTANCE) < _CUT_DISTANCE)
    near = mesh.triangles[near_vertices[mesh.triangles].all(axis=1)]
    above = mesh.vertices[:, 1] - np.interp(mesh.vertices[:, 0], line[:, 0], line[:, 1])
    above = np.where(np.abs(above) < _LINE_TOLERANCE, _LINE_TOLERANCE, above)
    cut = _find_cut(mesh.vertices, near, above, line[[0, -1], 0])
    if len(cut.edges) < _MIN_EDGES:
        return mesh
    outwards = bool(triangle_normals(mesh.vertices, near)[:, 2].sum() > 0)
    return build_mesh(_add_mouth_cavity(_split(mesh, cut, above > 0), outwards=outwards))


@dataclass(frozen=True)
class _Cut:
    """The edges that are cut, ordered from the right corner of the mouth to the left.

    edges : (k, 2) vertices, the smaller index first
    fractions : (k,) position of the cut from the first vertex (0) to the second (1)
    """

    edges: NDArray[np.int64]
    fractions: NDArray[np.float64]


@dataclass(frozen=True)
class _CutMesh:
    """A mesh cut between its lips: the (k,) vertices of either rim from right to left, and the two where they end."""

    raw: RawMesh
    upper: NDArray[np.int64]
    lower: NDArray[np.int64]
    ends: tuple[int, int]


def _find_cut(
    vertices: NDArray[np.float64], near: NDArray[np.int32], above: NDArray[np.float64], ends: NDArray[np.float64]
) -> _Cut:
    """Find the edges of the triangles near the lips that cross the line between its ends, (2,) x.

    above : (V,) height of each vertex above the line
    """
    edges = np.unique(np.sort(triangle_edges(near), axis=1).astype(np.int64), axis=0)
    edges = edges[(above[edges[:, 0]] > 0) != (above[edges[:, 1]] > 0)]
    first, second = above[edges].T
    fractions = first / (first - second)
    x = vertices[edges[:, 0], 0] * (1 - fractions) + vertices[edges[:, 1], 0] * fractions
    order = np.argsort(x)
    order = order[(x[order] > ends[0]) & (x[order] < ends[1])]
    return _Cut(edges[order], fractions[order])


# A triangle's corners are rotated until its first edge is cut, and with two cuts its last one too. The pieces, by their
# corners: 0, 1, 2 the triangle's own; 3 and 4 the cut of the first edge, on the lip of corner 0 and on the other; 5 and
# 6 that of the last edge.
_ONE_CUT = np.array([[0, 3, 2], [4, 1, 2]])
_TWO_CUTS = np.array([[0, 3, 5], [4, 1, 2], [4, 2, 6]])


def _split(mesh: Mesh, cut: _Cut, upper: NDArray[np.bool_]) -> _CutMesh:
    """Split the triangles at the cut edges. upper : (V,) whether a vertex belongs to the upper lip."""
    count, cuts = len(mesh.vertices), len(cut.edges)
    new = count + np.arange(2 * cuts).reshape(2, cuts)  # of the upper lip, of the lower
    corners = np.stack([mesh.triangles, mesh.render_triangles], axis=-1).astype(np.int64)
    edge_cuts = _edge_cuts(mesh.triangles.astype(np.int64), cut, count)
    touched = np.flatnonzero((edge_cuts >= 0).any(axis=1))
    edge_cuts, own = edge_cuts[touched], corners[touched]
    two = (edge_cuts >= 0).sum(axis=1) == 2
    first_edge = np.where(two, ((edge_cuts < 0).argmax(axis=1) + 2) % 3, (edge_cuts >= 0).argmax(axis=1))
    own = np.take_along_axis(own, ((first_edge[:, None] + np.arange(3)) % 3)[..., None], axis=1)
    lip = np.where(upper[own[:, 0, 0]], 0, 1)
    choices, uvs = [own[:, 0], own[:, 1], own[:, 2]], [mesh.uvs]
    for edge, far in ((first_edge, 1), ((first_edge + 2) % 3, 2)):
        at = edge_cuts[np.arange(len(own)), edge]
        start, end = own[:, 0], own[:, far]
        t = np.where(start[:, 0] < end[:, 0], cut.fractions[at], 1 - cut.fractions[at])[:, None]
        uv_rows = sum(map(len, uvs)) + np.arange(len(own))
        uvs.append(mesh.uvs[start[:, 1]] * (1 - t) + mesh.uvs[end[:, 1]] * t)
        choices += [np.stack([new[lip, at], uv_rows], axis=1), np.stack([new[1 - lip, at], uv_rows], axis=1)]
    seven = np.stack(choices, axis=1)
    pieces = [seven[~two][:, _ONE_CUT].reshape(-1, 3, 2), seven[two][:, _TWO_CUTS].reshape(-1, 3, 2)]
    kept = np.setdiff1d(np.arange(len(corners)), touched)
    origin = np.concatenate([kept, touched[~two].repeat(2), touched[two].repeat(3)])
    first, second = mesh.vertices[cut.edges[:, 0]], mesh.vertices[cut.edges[:, 1]]
    positions = first + cut.fractions[:, None] * (second - first)
    raw = RawMesh(
        positions=np.concatenate([mesh.vertices, positions, positions]),
        uvs=np.concatenate(uvs),
        corners=np.concatenate([corners[kept], *pieces]),
        groups={name: np.flatnonzero(np.isin(origin, members)) for name, members in mesh.groups.items()},
        texture=mesh.texture,
    )
    new_colours: NDArray[np.float64] | None = None
    if mesh.vertex_colours is not None:
        ends = mesh.vertex_colours.astype(np.float64)[cut.edges]  # (k, 2, 3)
        new_colours = np.tile(ends[:, 0] + cut.fractions[:, None] * (ends[:, 1] - ends[:, 0]), (2, 1))
    raw = with_colours_of(raw, mesh, origin=origin, new_colours=new_colours)
    tips = {int(at): int(tip) for at, tip in zip(edge_cuts.max(axis=1)[~two], own[~two, 2, 0], strict=True)}
    return _CutMesh(raw, new[0], new[1], (tips.get(0, int(new[0, 0])), tips.get(cuts - 1, int(new[0, -1]))))


def _edge_cuts(triangles: NDArray[np.int64], cut: _Cut, count: int) -> NDArray[np.intp]:
    """Return (F, 3): the cut of each triangle's edges, the first from corner 0 to corner 1; -1 for none."""
    starts, ends = triangles, np.roll(triangles, -1, axis=1)
    keys = np.minimum(starts, ends) * count + np.maximum(starts, ends)
    cut_keys = cut.edges[:, 0] * count + cut.edges[:, 1]
    order = np.argsort(cut_keys)
    at = np.minimum(np.searchsorted(cut_keys[order], keys), len(cut_keys) - 1)
    return np.asarray(np.where(cut_keys[order][at] == keys, order[at], -1))


def _add_mouth_cavity(cut_mesh: _CutMesh, *, outwards: bool) -> RawMesh:
    """Extrude the rim to a cavity. outwards : whether the mesh's triangles face outwards."""
    raw = cut_mesh.raw
    rim = raw.positions[cut_mesh.upper]
    centre, half_width = (rim[0, 0] + rim[-1, 0]) / 2, max((rim[-1, 0] - rim[0, 0]) / 2, 1e-9)
    t = (rim[:, 0] - centre) / half_width
    height = np.sqrt(np.maximum(1 - t**2, 0.0))[:, None]  # 0 in the corners of the mouth, 1 in the middle
    back, up = _BAG_PROFILE.T
    x = centre + half_width * t[:, None] * _NARROWING
    y = rim[:, 1:2] + height * up
    z = rim[:, 2:3] - (_CORNER_DEPTH + (1 - _CORNER_DEPTH) * height) * back
    positions = np.stack([x, y, z], axis=-1)  # (k, p, 3)
    inner = len(raw.positions) + np.arange(x.size).reshape(x.shape)
    grid = np.column_stack([cut_mesh.upper, inner, cut_mesh.lower])
    caps = [
        np.stack([np.full(len(path) - 1, tip), path[:-1], path[1:]], axis=-1)
        for tip, path in ((cut_mesh.ends[0], grid[0]), (cut_mesh.ends[1], grid[-1, ::-1]))
    ]
    triangles = np.concatenate([grid_triangles(grid), *caps])
    if outwards:
        triangles = triangles[:, ::-1]
    added = len(raw.corners) + np.arange(len(triangles))
    materials, colours = raw.triangle_materials, raw.vertex_colours
    return replace(
        raw,
        positions=np.concatenate([raw.positions, positions.reshape(-1, 3)]),
        corners=np.concatenate([raw.corners, np.stack([triangles, np.full_like(triangles, -1)], axis=-1)]),
        groups=raw.groups | {_MOUTH: np.concatenate([raw.groups.get(_MOUTH, added[:0]), added])},
        triangle_materials=None if materials is None else np.append(materials, np.full(len(added), -1, np.int32)),
        vertex_colours=None if colours is None else np.concatenate([colours, np.ones((inner.size, 3), np.float32)]),
    )
