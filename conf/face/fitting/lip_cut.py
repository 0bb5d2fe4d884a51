"""Open a mouth that a mesh has shut: cut the lips where they meet and put a bag behind them.

Strategy. On many meshes the lips are one surface: when the jaw goes down, skin is stretched over the mouth. The line
where the lips meet is known from the inner lip points. Every edge of the surface that crosses it is cut, the triangles
there are split, and the new vertices are made twice, once for either lip. The rim that this makes is drawn out
backwards to a bag, so that an open mouth shows its inside and not the back of the head.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.formats.obj import RawMesh
from conf.face.mesh.mesh import Mesh, build_mesh
from conf.face.mesh.surface_graph import SurfaceGraph

# Model centimetres, 6.4 between the pupils.
# From lip to lip round the corner, or through the mouth, times the way straight over the lips: measured 1.0 and 1.05
# where lips are one surface, 1.76 to 2.98 on ninety heads where they are not.
_OPEN_RATIO = 1.5
_SKIN_TOLERANCE = 0.3  # that the skin may be farther than another shell
_CUT_DISTANCE = 1.6  # along the skin from the line, that triangles may be cut
_LINE_TOLERANCE = 1e-3  # what is nearer to the line is taken for the upper lip's
_MOUTH = "mouth"
_MIN_EDGES = 3  # edges that are worth a cut
# Once round the bag from the upper lip to the lower: how far back, and up or down.
_BAG_PROFILE = np.array(
    # The narrow first ring keeps the bag out of the shading of the lips.
    [[0.08, 0], [0.5, 0.15], [1.5, 0.7], [3.0, 0.9], [4.0, 0], [3.0, -0.9], [1.5, -0.7], [0.5, -0.15], [0.08, 0]]
)
_CORNER_DEPTH = 0.35  # of the depth in the middle, in the corners of the mouth
_NARROWING = np.array([1.0, 0.97, 0.92, 0.85, 0.75, 0.85, 0.92, 0.97, 1.0])  # of the mouth's width, at the same places


def has_open_lips(points: NDArray[np.float64], surface: SurfaceGraph, /) -> bool:
    """Say whether the way along the surface from one lip to the other is longer than over the lips.

    points : (n, 3) control points in centimetres, about 6.4 between the pupils
    """
    across = points[_PROFILE_POINTS]
    upper, lower = surface.nearest_vertices(across[[0, -1]], tolerance=_SKIN_TOLERANCE)
    over_the_lips = float(np.linalg.norm(np.diff(across, axis=0), axis=1).sum())
    limit = _OPEN_RATIO * over_the_lips
    return bool(surface.distances(np.array([upper]), limit=limit)[lower] >= limit)


def cut_lips(mesh: Mesh, points: NDArray[np.float64], surface: SurfaceGraph, /) -> Mesh:
    """Return the mesh cut between its lips, with a bag behind them in the group "mouth"; itself if nothing can be cut.

    mesh, points, surface : upright, in model centimetres; points (n, 3)
    New vertices come after those of the mesh.
    """
    line = (points[_UPPER] + points[_LOWER]) / 2
    line = line[np.argsort(line[:, 0])]
    seeds = surface.nearest_vertices(points[[*_UPPER, *_LOWER]], tolerance=_SKIN_TOLERANCE)
    around = np.asarray(surface.distances(seeds, limit=_CUT_DISTANCE) < _CUT_DISTANCE)
    near = np.asarray(around[mesh.triangles].all(axis=1))
    above = mesh.vertices[:, 1] - np.interp(mesh.vertices[:, 0], line[:, 0], line[:, 1])
    above = np.where(np.abs(above) < _LINE_TOLERANCE, _LINE_TOLERANCE, above)
    cut = _find_cut(mesh, near, above, line[[0, -1], 0])
    if len(cut.edges) < _MIN_EDGES:
        return mesh
    outwards = _face_viewer(mesh.vertices[mesh.triangles[near]])
    return build_mesh(_add_mouth_cavity(_split(mesh, cut, above > 0), cut, outwards))


@dataclass(frozen=True)
class _Cut:
    """The edges that are cut, ordered from the right corner of the mouth to the left.

    edges : (k, 2) vertices, the smaller number first
    shares : (k,) how far from the first to the second the cut is
    """

    edges: NDArray[np.int64]
    fractions: NDArray[np.float64]

    def interpolate(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the (k, d) values at the cuts from those of the vertices, (V, d)."""
        first, second = values[self.edges[:, 0]], values[self.edges[:, 1]]
        return np.asarray(first + self.fractions[:, None] * (second - first))


@dataclass(frozen=True)
class _CutMesh:
    """A mesh whose lips are apart: the (k,) vertices of either rim from right to left, and the two where they end."""

    raw: RawMesh
    upper: NDArray[np.int64]
    lower: NDArray[np.int64]
    ends: tuple[int, int]


def _find_cut(mesh: Mesh, near: NDArray[np.bool_], above: NDArray[np.float64], ends: NDArray[np.float64]) -> _Cut:
    """Find the edges of the triangles near the lips that cross the line between its ends, (2,) x."""
    edges = np.sort(mesh.triangles[near][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1).astype(np.int64)
    edges = np.unique(edges, axis=0)
    edges = edges[(above[edges[:, 0]] > 0) != (above[edges[:, 1]] > 0)]
    first, second = above[edges].T
    shares = first / (first - second)
    x = mesh.vertices[edges[:, 0], 0] * (1 - shares) + mesh.vertices[edges[:, 1], 0] * shares
    order = np.argsort(x)
    order = order[(x[order] > ends[0]) & (x[order] < ends[1])]
    return _Cut(edges[order], shares[order])


def _face_viewer(corners: NDArray[np.float64]) -> bool:
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return bool(normals[:, 2].sum() > 0)


# A triangle is turned until its first edge is cut, and with two cuts its last one too. Its pieces, by their corners: 0,
# 1 and 2 its own; 3 and 4 the cut of the first edge, on the lip of corner 0 and on the other; 5 and 6 that of the last.
_ONE_CUT = np.array([[0, 3, 2], [4, 1, 2]])
_TWO_CUTS = np.array([[0, 3, 5], [4, 1, 2], [4, 2, 6]])


def _split(mesh: Mesh, cut: _Cut, upper: NDArray[np.bool_]) -> _CutMesh:
    """Cut the edges; upper (V,) says which vertices are the upper lip's."""
    count, cuts = len(mesh.vertices), len(cut.edges)
    new = count + np.arange(2 * cuts).reshape(2, cuts)  # of the upper lip, of the lower
    corners = np.stack([mesh.triangles, mesh.render_triangles], axis=-1).astype(np.int64)
    number = _edge_cuts(mesh.triangles.astype(np.int64), cut, count)
    touched = np.flatnonzero((number >= 0).any(axis=1))
    number, own = number[touched], corners[touched]
    both = (number >= 0).sum(axis=1) == 2
    turn = np.where(both, ((number < 0).argmax(axis=1) + 2) % 3, (number >= 0).argmax(axis=1))
    own = np.take_along_axis(own, ((turn[:, None] + np.arange(3)) % 3)[..., None], axis=1)
    lip = np.where(upper[own[:, 0, 0]], 0, 1)
    choices, uvs = [own[:, 0], own[:, 1], own[:, 2]], [mesh.uvs]
    for edge, far in ((turn, 1), ((turn + 2) % 3, 2)):
        at = number[np.arange(len(own)), edge]
        start, end = own[:, 0], own[:, far]
        share = np.where(start[:, 0] < end[:, 0], cut.fractions[at], 1 - cut.fractions[at])[:, None]
        looks = sum(map(len, uvs)) + np.arange(len(own))
        uvs.append(mesh.uvs[start[:, 1]] * (1 - share) + mesh.uvs[end[:, 1]] * share)
        choices += [np.stack([new[lip, at], looks], axis=1), np.stack([new[1 - lip, at], looks], axis=1)]
    seven = np.stack(choices, axis=1)
    pieces = [seven[~both][:, _ONE_CUT].reshape(-1, 3, 2), seven[both][:, _TWO_CUTS].reshape(-1, 3, 2)]
    kept = np.setdiff1d(np.arange(len(corners)), touched)
    origin = np.concatenate([kept, touched[~both].repeat(2), touched[both].repeat(3)])
    places = cut.interpolate(mesh.vertices)
    raw = RawMesh(
        positions=np.concatenate([mesh.vertices, places, places]),
        uvs=np.concatenate(uvs),
        corners=np.concatenate([corners[kept], *pieces]),
        groups={name: np.flatnonzero(np.isin(origin, members)) for name, members in mesh.groups.items()},
        texture=mesh.texture,
    )
    tips = {int(at): int(tip) for at, tip in zip(number.max(axis=1)[~both], own[~both, 2, 0], strict=True)}
    ends = (tips.get(0, int(new[0, 0])), tips.get(cuts - 1, int(new[0, -1])))
    return _CutMesh(raw, new[0], new[1], ends)


def _edge_cuts(triangles: NDArray[np.int64], cut: _Cut, count: int) -> NDArray[np.intp]:
    """Return (F, 3): the cut of each triangle's edges, the first from its first corner to its second; -1 for none."""
    starts, ends = triangles, np.roll(triangles, -1, axis=1)
    keys = np.minimum(starts, ends) * count + np.maximum(starts, ends)
    known = cut.edges[:, 0] * count + cut.edges[:, 1]
    order = np.argsort(known)
    at = np.minimum(np.searchsorted(known[order], keys), len(known) - 1)
    return np.asarray(np.where(known[order][at] == keys, order[at], -1))


def _add_mouth_cavity(slit: _CutMesh, cut: _Cut, outwards: bool) -> RawMesh:
    """Draw the rim of the slit out to a bag; outwards says which way the mesh's triangles face."""
    raw = slit.raw
    rim = raw.positions[slit.upper]
    middle, half = (rim[0, 0] + rim[-1, 0]) / 2, max((rim[-1, 0] - rim[0, 0]) / 2, 1e-9)
    along = (rim[:, 0] - middle) / half
    full = np.sqrt(np.maximum(1 - along**2, 0.0))[:, None]  # 0 in the corners of the mouth
    back, up = _BAG_PROFILE.T
    ring = np.stack(
        [
            middle + half * along[:, None] * _NARROWING,
            rim[:, 1:2] + full * up,
            rim[:, 2:3] - (_CORNER_DEPTH + (1 - _CORNER_DEPTH) * full) * back,
        ],
        axis=-1,
    )  # (k, p, 3)
    first = len(raw.positions)
    inner = first + np.arange(ring.shape[0] * ring.shape[1]).reshape(ring.shape[:2])
    columns = np.column_stack([slit.upper, inner, slit.lower])
    a, b, c, d = columns[:-1, :-1], columns[1:, :-1], columns[1:, 1:], columns[:-1, 1:]
    walls = np.concatenate([np.stack([a, b, c], axis=-1).reshape(-1, 3), np.stack([a, c, d], axis=-1).reshape(-1, 3)])
    caps = [
        np.stack([np.full(len(way) - 1, tip), way[:-1], way[1:]], axis=-1)
        for tip, way in ((slit.ends[0], columns[0]), (slit.ends[1], columns[-1, ::-1]))
    ]
    triangles = np.concatenate([walls, *caps])
    if outwards:
        triangles = triangles[:, ::-1]
    old, added = len(raw.corners), len(triangles)
    return replace(
        raw,
        positions=np.concatenate([raw.positions, ring.reshape(-1, 3)]),
        corners=np.concatenate([raw.corners, np.stack([triangles, np.full_like(triangles, -1)], axis=-1)]),
        groups=raw.groups
        | {_MOUTH: np.concatenate([raw.groups.get(_MOUTH, old + np.arange(0)), old + np.arange(added)])},
    )


_PROFILE_POINTS = [
    CONTROL_POINT_INDEX[f"{lip}_mid"]
    for lip in ("outer_lip_upper", "inner_lip_upper", "inner_lip_lower", "outer_lip_lower")
]
_UPPER, _LOWER = (
    [
        CONTROL_POINT_INDEX[f"inner_lip_{place}"]
        for place in ("corner_r", f"{lip}_r", f"{lip}_mid", f"{lip}_l", "corner_l")
    ]
    for lip in ("upper", "lower")
)
