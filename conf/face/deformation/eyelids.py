"""What eyelids do beyond interpolation: they stop where they meet, the upper in front, and their lashes turn with them.

Strategy. Lashes are surfaces of their own that stand on the edge of a lid. Interpolated like skin they would keep their
direction in a blink and stand upright on the closed lid. So each lash vertex has a root on a smooth curve through the
vertices at the edge; it moves with its root, and its offset from there turns as the middle of the lid does around the
eye.

SciPy is imported where lids and lashes are searched for: a face that was prepared before needs no search.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.interpolation import smoothstep
from conf.face.mesh.mesh import Mesh

_UPPER, _LOWER = ([CONTROL_POINT_INDEX[f"eyelid_{lid}_{side}"] for side in "lr"] for lid in ("upper", "lower"))
# Of the neutral gap, by which a closed upper lid covers the lower one: without it a slit stays open between vertices,
# and a sculpted blink of 1.35 gaps makes the lids of most heads sag.
_OVERLAP = 0.06
_LID_RADIUS = 1.2  # cm, of a human eye: on the larger eyeballs of most meshes a lid turns less than it should
_MAX_TURN = 1.6  # times the rotation of the lid around the eye
# In cm, 6.4 between the pupils.
_BOX = (0.6, 1.5)  # beyond the corners of an eye, and above and below its lids, within which lashes lie
_ROOT_DISTANCE = 0.25  # from the line of a lid's edge, within which lashes are attached
_MIN_LENGTH = 0.15  # from the line of the edge: tear film and waterline do not reach farther
_COVER = 0.08  # by which the edge of a closed upper lid stands out: lids that meet intersect in a ragged line
_COVER_REACH = 0.6  # from the line of the edge, over which it begins to stand out
_COVER_CORNER = 0.3  # by which the line of the upper edge is nearer than that of the lower one; less near the corners
_COVER_START, _COVER_RANGE = 0.5, 0.3  # of the lid's travel: where its edge begins to stand out, and how fast
_DEGREE = 3  # of the curve through the roots
_LINE_SAMPLES = 33


def stop_at_contact(points: NDArray[np.float64], offsets: NDArray[np.float32], /) -> NDArray[np.float32]:
    """Return the offsets of the control points, those of upper lids reduced so that they cover the lower lids barely.

    points, offsets : (n, 3) neutral control points and their offsets, model units
    """
    gaps = points[_UPPER, 1] - points[_LOWER, 1]
    least = np.minimum(gaps, -_OVERLAP * np.abs(gaps))  # what overlaps in the neutral pose may stay so
    excess = least - (gaps + offsets[_UPPER, 1] - offsets[_LOWER, 1])
    if (excess <= 0).all():
        return offsets
    stopped = offsets.copy()
    stopped[_UPPER, 1] += np.maximum(excess, 0.0).astype(np.float32)
    return stopped


@dataclass(frozen=True)
class Lashes:
    """The lashes of one eye.

    vertices : (k,) of the lashes
    attached : (a,) vertices at the edges of the lids
    weights : (k, a) float32, of the attached vertices in the root of each, adding up to 1
    middles : (2, a) float32, the same for the middle of the upper and of the lower lid; zeros for a lid without lashes
    lids : (k,) 0 for lashes of the upper lid, 1 for those of the lower
    turn : times the rotation of the middle around the eye
    """

    vertices: NDArray[np.int64]
    attached: NDArray[np.int64]
    weights: NDArray[np.float32]
    middles: NDArray[np.float32]
    lids: NDArray[np.intp]
    turn: float

    def apply(
        self, neutral: NDArray[np.float32], vertices: NDArray[np.float32], centre: NDArray[np.float32], /
    ) -> None:
        """Move the lashes with their lids.

        neutral, vertices : (V, 3) neutral, and deformed: changed in place
        centre : (3,) of the eye
        """
        rest, moved = neutral[self.attached], vertices[self.attached]
        before, after = self.middles @ rest, self.middles @ moved
        turns = np.stack(
            [rotation_between(*lid, self.turn) for lid in zip(before - centre, after - centre, strict=True)]
        )
        offsets = neutral[self.vertices] - self.weights @ rest
        vertices[self.vertices] = np.einsum("kij,kj->ki", turns[self.lids], offsets) + self.weights @ moved
        # An upper lid that comes to lie on the lower one pushes the lashes of this one down.
        overlap = float(after[0, 1] - after[1, 1]) - min(float(before[0, 1] - before[1, 1]), 0.0)
        if overlap < 0 and self.middles.any(axis=1).all():
            vertices[self.vertices[self.lids == 1], 1] += np.float32(overlap)


@dataclass(frozen=True)
class LidCover:
    """The edge of an upper lid, which closes in front of the lower one.

    vertices : (k,) at the edge
    distances : (k,) float32, by which each stands out in a closed eye
    middle : vertex at the lid's control point
    travel : of the middle until the eye is closed
    """

    vertices: NDArray[np.int64]
    distances: NDArray[np.float32]
    middle: int
    travel: float

    def apply(
        self, neutral: NDArray[np.float32], vertices: NDArray[np.float32], centre: NDArray[np.float32], /
    ) -> None:
        """Move the edge of a closing lid away from the eye. Arguments are those of `Lashes.apply`."""
        closed = float(neutral[self.middle, 1] - vertices[self.middle, 1]) / self.travel
        amount = np.float32(smoothstep(np.array((closed - _COVER_START) / _COVER_RANGE)))
        if amount > 0:
            outwards = vertices[self.vertices] - centre
            outwards /= np.maximum(np.linalg.norm(outwards, axis=1, keepdims=True), np.float32(1e-6))
            vertices[self.vertices] += outwards * (amount * self.distances)[:, None]


def find_lid_cover(
    mesh: Mesh, points: NDArray[np.float64], skin: NDArray[np.int64], /, *, side: str
) -> LidCover | None:
    """Return the edge of the upper lid of one eye; None if it is closed. Arguments are those of `find_lashes`."""
    from scipy.spatial import KDTree

    lids = _lid_points(points, side)
    travel = float(lids[1, 1] - lids[2, 1])
    if travel < _MIN_LENGTH or not len(skin):
        return None
    positions = mesh.vertices[skin]
    upper, lower = (KDTree(_edge_line(*lids[[0, middle, 3]])).query(positions)[0] for middle in (1, 2))
    weights = smoothstep(1 - upper / _COVER_REACH) * smoothstep((lower - upper) / _COVER_CORNER)
    edge = np.flatnonzero(weights)
    middle = int(skin[KDTree(positions).query(lids[1])[1]])
    return LidCover(skin[edge], (_COVER * weights[edge]).astype(np.float32), middle, travel)


def rotation_between(before: NDArray[np.float32], after: NDArray[np.float32], factor: float, /) -> NDArray[np.float32]:
    """Return the (3, 3) rotation in the plane of two vectors (3,) by the angle between them times factor.

    Source: Rodrigues' rotation formula.
    """
    (ax, ay, az), (bx, by, bz) = before.tolist(), after.tolist()
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    length = math.hypot(x, y, z)
    angle = factor * math.atan2(length, ax * bx + ay * by + az * bz)
    scale = 1 / max(length, 1e-12)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) * scale
    return np.asarray(np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross, np.float32)


def find_lashes(
    mesh: Mesh, points: NDArray[np.float64], centre: NDArray[np.float64], skin: NDArray[np.int64], /, *, side: str
) -> Lashes | None:
    """Return the lashes of one eye, None if there are none: small parts that stand on the edge of a lid.

    mesh, points : upright, in model centimetres; points (n, 3)
    centre : (3,) of the eyeball; skin : vertices that are not of eyeballs, teeth or tongue; side : "l" or "r"
    """
    from scipy.spatial import KDTree

    from conf.face.mesh.surface_graph import component_labels, triangle_edges

    corners = _lid_points(points, side)
    low, high = corners[:, :2].min(axis=0) - _BOX, corners[:, :2].max(axis=0) + _BOX
    in_box = (mesh.vertices[:, :2] > low) & (mesh.vertices[:, :2] < high)
    inside = in_box.all(axis=1) & (mesh.vertices[:, 2] > centre[2])
    movable = np.zeros(len(mesh.vertices), np.bool_)
    movable[skin] = True
    near = mesh.triangles[inside[mesh.triangles].any(axis=1) & movable[mesh.triangles].all(axis=1)]
    used, triangles = np.unique(near, return_inverse=True)
    if not len(used):
        return None
    labels = component_labels(triangle_edges(triangles.reshape(-1, 3).astype(np.int32)), len(used))
    is_skin = np.isin(labels, labels[~inside[used]])  # it runs on beyond the eye
    positions = mesh.vertices[used]
    lines = [_edge_line(*corners[[0, middle, 3]]) for middle in (1, 2)]
    to_lids = np.stack([KDTree(line).query(positions)[0] for line in lines])  # (2, k)
    distance = to_lids.min(axis=0)
    reach = np.zeros(labels.max() + 1)
    np.maximum.at(reach, labels, distance)
    is_lash = ~is_skin & (reach[labels] > _MIN_LENGTH)
    attached = is_lash & (distance < _ROOT_DISTANCE)
    is_lash &= np.isin(labels, labels[attached])
    if not is_skin.any() or not is_lash.any():
        return None
    lash, seeds = np.flatnonzero(is_lash), np.flatnonzero(attached)
    weights, middles, nearest = np.zeros((len(lash), len(seeds))), np.zeros((2, len(seeds))), [np.inf, np.inf]
    lids = np.zeros(len(lash), np.intp)
    along = (positions[:, 0] - corners[[0, 3], 0].mean()) / np.ptp(corners[[0, 3], 0]) * 2
    for label in np.unique(labels[lash]):
        rows, columns = labels[lash] == label, labels[seeds] == label
        weights[np.ix_(rows, columns)] = curve_weights(along[lash[rows]], along[seeds[columns]])
        lid = int(to_lids[:, seeds[columns]].mean(axis=1).argmin())
        lids[rows] = lid
        from_middle = float(np.abs(along[seeds[columns]]).min())
        if from_middle < nearest[lid]:  # of several parts on a lid, the one in its middle turns all
            nearest[lid] = from_middle
            middles[lid] = 0.0
            middles[lid, columns] = curve_weights(np.zeros(1), along[seeds[columns]])[0]
    turn = float(np.clip(np.linalg.norm(corners[1] - centre) / _LID_RADIUS, 1.0, _MAX_TURN))
    return Lashes(used[lash], used[seeds], weights.astype(np.float32), middles.astype(np.float32), lids, turn)


def curve_weights(positions: NDArray[np.float64], samples: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return the (k, a) weights of values at samples (a,) in their least-squares polynomial at positions (k,).

    Positions beyond the samples get the value at the nearest end.
    """
    degree = min(_DEGREE, len(samples) - 1)
    clipped = np.clip(positions, samples.min(), samples.max())
    at, on = (np.vander(x, degree + 1) for x in (clipped, samples))
    return np.asarray(at @ np.linalg.pinv(on))


def _lid_points(points: NDArray[np.float64], side: str) -> NDArray[np.float64]:
    """Return (4, 3): the outer corner of an eye, its upper and its lower lid, its inner corner."""
    names = ("eye_outer_corner", "eyelid_upper", "eyelid_lower", "eye_inner_corner")
    return points[[CONTROL_POINT_INDEX[f"{name}_{side}"] for name in names]]


def _edge_line(outer: NDArray[np.float64], lid: NDArray[np.float64], inner: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (s, 3) samples of the parabola from corner to corner through a lid's point, (3,) each."""
    s = np.linspace(-1, 1, _LINE_SAMPLES)[:, None]
    return np.asarray((1 - s * s) * lid + s * (s - 1) / 2 * outer + s * (s + 1) / 2 * inner)
