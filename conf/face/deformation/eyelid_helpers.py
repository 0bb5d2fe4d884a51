"""Helper points on the edges of the eyelids, between the control points.

An eyelid has one control point on its edge, in the middle; the ends are the corners of the eye. Interpolated between
these alone an eye closes in a V shape. Helper points close it over its whole width: each moves with the lid's control
point in proportion to the width of the gap between the lids there, relative to the gap at the control point. Without a
measurement on the mesh the edge is assumed to be a parabola through the three points, and so is the gap. Displacements
of helper points are fixed weighted sums of three control points', so they fold into the operator.

Only a fold of skin above the lid follows a blink. Interpolated between lid and brow alone, the lower half of the brow
would be pulled down with it: brow helpers above the fold move as the brow does.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.deformation.regions import InfluenceField, Regions
from conf.face.deformation.rig import EyelidHelpers
from conf.face.mesh.depth_profiles import LabelledMesh, find_lid_edge
from conf.face.mesh.raycast import cast_front_rays

_ARC_POSITIONS = (-0.75, -0.4, 0.4, 0.75)  # on the edge, from -1 at the outer corner to 1 at the inner
_EDGE_POSITIONS = (-0.9, -0.75, -0.4, 0.4, 0.75, 0.9)  # the same on a measured edge, which runs on to the corners
_CORNER_OVERLAP = 0.18  # of the lid's motion, added near the corners, where smoothing leaves a closed lid 1 mm open
_CORNER_POSITION = 0.7
_BROW_POSITIONS = (-0.8, -0.3, 0.3, 0.8)  # of brow helpers, as those on the edge
# From the edge of the upper lid (0) to the brow (1): the fold ends at the first; one row alone would be overshot.
_BROW_HEIGHTS = (0.75, 1.0)
_MAX_BROW_DEPTH = 0.8  # cm from the line between lid and brow to the skin; what is farther off is hair
_BROWS = ("brow_outer", "brow_top", "brow_inner")
_LIDS = ("eyelid_upper_l", "eyelid_upper_r", "eyelid_lower_l", "eyelid_lower_r")
_SEARCH_MARGIN = 1.0  # cm around the lids
_GAP_RANGE = (0.03, 1.2)  # of the gap at the control points; outside it a measurement is not a gap between lids


def helpers_on_parabola(points: NDArray[np.float64], /) -> EyelidHelpers:
    """Return helper points on parabolas through the control points (n, 3)."""
    return EyelidHelpers(PARABOLA_WEIGHTS @ points, PARABOLA_WEIGHTS, HELPER_LIDS)


def helpers_on_edges(points: NDArray[np.float64], mesh: LabelledMesh, /) -> EyelidHelpers:
    """Return helper points on the edges of a mesh's eyelids, on the parabola where no edges are found.

    points : (n, 3) control points on the mesh; all upright, in model centimetres
    """
    weights, helper_lids = _parabola_weights(_EDGE_POSITIONS), _helper_lids(_EDGE_POSITIONS)
    positions = weights @ points
    mesh = _nearby(mesh, positions)
    for side in range(2):
        for i, s in enumerate(_EDGE_POSITIONS):
            pair = [side * len(_EDGE_POSITIONS) + i, (side + 2) * len(_EDGE_POSITIONS) + i]
            inside = float(positions[pair, 1].mean())
            upper, lower = (find_lid_edge(mesh, positions[row], inside) for row in pair)
            if upper is None or lower is None:
                continue
            lids = points[helper_lids[pair], 1]
            ratio = float(upper[1] - lower[1]) / float(lids[0] - lids[1])
            if _GAP_RANGE[0] < ratio < _GAP_RANGE[1]:
                positions[pair] = [upper, lower]
                weight = ratio + (_CORNER_OVERLAP if abs(s) > _CORNER_POSITION else 0.0)
                corners = (1 - weight) * (1 - s) / 2, (1 - weight) * (1 + s) / 2
                weights[pair] = [_weight_row(lid, weight, *corners) for lid in (_LIDS[side], _LIDS[side + 2])]
    return EyelidHelpers(positions, weights, helper_lids)


def with_brow_helpers(helpers: EyelidHelpers, points: NDArray[np.float64], mesh: LabelledMesh, /) -> EyelidHelpers:
    """Return the helper points and more between the upper lids and the brows.

    points : (n, 3) control points on the mesh; all upright, in model centimetres
    """
    on_lids, weights = _parabola_weights(_BROW_POSITIONS), []
    upper = on_lids[: 2 * len(_BROW_POSITIONS)] @ points
    for side, positions in zip("lr", np.split(upper, 2), strict=True):
        rows = [CONTROL_POINT_INDEX[f"{name}_{side}"] for name in _BROWS]
        rows.sort(key=lambda row: points[row, 0])
        for x in positions[:, 0]:
            weights.append(np.zeros(CONTROL_POINT_COUNT))
            weights[-1][rows] = [np.interp(x, points[rows, 0], unit) for unit in np.eye(len(rows))]
    added = np.array(weights)
    positions = np.concatenate([upper + height * (added @ points - upper) for height in _BROW_HEIGHTS])
    added = np.tile(added, (len(_BROW_HEIGHTS), 1))
    hits = cast_front_rays(positions[:, :2], mesh.vertices, mesh.triangles).points
    on_skin = np.abs(hits[:, 2] - positions[:, 2]) < _MAX_BROW_DEPTH  # False for nan, a miss
    positions[on_skin] = hits[on_skin]
    return EyelidHelpers(
        np.concatenate([helpers.positions, positions]),
        np.concatenate([helpers.weights, added]),
        np.concatenate([helpers.lids, added.argmax(axis=1)]),
    )


def append_helpers(
    points: NDArray[np.float64], regions: Regions, helpers: EyelidHelpers, /
) -> tuple[NDArray[np.float64], Regions]:
    """Return the control points (n, 3) followed by the helper points, and the regions for all of them."""
    fields = []
    for field in regions.fields:
        excluded = [len(points) + i for i, lid in enumerate(helpers.lids) if lid in field.excluded]
        fields.append(InfluenceField(field.weights, (*field.excluded, *excluded)))
    return np.concatenate([points, helpers.positions]), Regions(tuple(fields), regions.anchors)


def fold_helpers(matrix: NDArray[np.float32], helpers: EyelidHelpers, /) -> NDArray[np.float32]:
    """Return the (V, n) operator of the control points from that of control and helper points, (V, n + h)."""
    own, added = np.split(matrix, [CONTROL_POINT_COUNT], axis=1)
    return np.asarray(own + added @ helpers.weights.astype(np.float32))


def _nearby(mesh: LabelledMesh, positions: NDArray[np.float64]) -> LabelledMesh:
    """Return the part of the mesh that a column of rays near any of the positions (h, 3) may hit."""
    corners = mesh.vertices[mesh.triangles][..., :2]
    low, high = positions.min(axis=0)[:2] - _SEARCH_MARGIN, positions.max(axis=0)[:2] + _SEARCH_MARGIN
    near = (corners.max(axis=1) > low).all(axis=1) & (corners.min(axis=1) < high).all(axis=1)
    return LabelledMesh(mesh.vertices, mesh.triangles[near], mesh.triangle_labels[near])


def _weight_row(lid: str, middle: float, outer: float, inner: float) -> NDArray[np.float64]:
    """Return the (n,) weights of a helper point: of its lid's control point and of the two corners of its eye."""
    row = np.zeros(CONTROL_POINT_COUNT)
    points = (lid, f"eye_outer_corner_{lid[-1]}", f"eye_inner_corner_{lid[-1]}")
    row[[CONTROL_POINT_INDEX[name] for name in points]] = middle, outer, inner
    return row


def _parabola_weights(positions: Sequence[float]) -> NDArray[np.float64]:
    """Return the (h, n) weights of helper points at positions on the parabolas of the four lids."""
    return np.array([_weight_row(lid, 1 - s * s, s * (s - 1) / 2, s * (s + 1) / 2) for lid in _LIDS for s in positions])


def _helper_lids(positions: Sequence[float]) -> NDArray[np.intp]:
    return np.array([CONTROL_POINT_INDEX[lid] for lid in _LIDS for _ in positions])


PARABOLA_WEIGHTS = _parabola_weights(_ARC_POSITIONS)  # (h, n)
HELPER_LIDS = _helper_lids(_ARC_POSITIONS)  # (h,) control point of each
