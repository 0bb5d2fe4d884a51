"""The edges of the lids, between the control points.

An upper lid has one control point on its edge, at the middle; its ends are the corners of the eye. Interpolated
between these alone an eye shuts like a V. Helper points on the edge shut it over its whole width: each moves with the
lid's control point as far as the gap between the lids is wide where it lies, as a share of the gap at the control
point. Without a look at the mesh the edge is taken for a parabola through the three, and so is the gap. Displacements
of helper points are fixed mixtures of three control points', so they fold into the operator.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.deformation.regions import InfluenceField, Regions
from conf.face.mesh.depth_profiles import LabelledMesh, find_lid_edge

_ARC_POSITIONS = (-0.75, -0.4, 0.4, 0.75)  # where on the edge, from -1 at the outer corner to 1 at the inner
_LIDS = ("eyelid_upper_l", "eyelid_upper_r", "eyelid_lower_l", "eyelid_lower_r")
_SEARCH_MARGIN = 1.0  # cm beyond the lids that is looked at
_GAP_RANGE = (0.1, 1.2)  # of the gap at the control points: what is measured beyond is no gap between lids
HELPER_LIDS = [
    CONTROL_POINT_INDEX[lid] for lid in _LIDS for _ in _ARC_POSITIONS
]  # (h,) the control point each helper point belongs to


@dataclass(frozen=True)
class EyelidHelpers:
    """The helper points of one face.

    places : (h, 3), the unit of the control points
    mixtures : (h, n) of control points' displacements in that of each helper point
    """

    positions: NDArray[np.float64]
    weights: NDArray[np.float64]


def helpers_on_parabola(points: NDArray[np.float64], /) -> EyelidHelpers:
    """Return helper points on parabolas through the control points (n, 3)."""
    return EyelidHelpers(PARABOLA_WEIGHTS @ points, PARABOLA_WEIGHTS)


def helpers_on_edges(points: NDArray[np.float64], shells: LabelledMesh, /) -> EyelidHelpers:
    """Return helper points on the edges of the lids of a mesh, on the parabola where no edges are seen.

    points : (n, 3) control points on the mesh; all upright, in model centimetres
    """
    places, mixtures = PARABOLA_WEIGHTS @ points, PARABOLA_WEIGHTS.copy()
    shells = _nearby(shells, places)
    for side in range(2):
        for i, s in enumerate(_ARC_POSITIONS):
            pair = [side * len(_ARC_POSITIONS) + i, (side + 2) * len(_ARC_POSITIONS) + i]
            inside = float(places[pair, 1].mean())
            edges = [find_lid_edge(shells, places[row], inside) for row in pair]
            owners = [HELPER_LIDS[row] for row in pair]
            share = 0.0 if edges[0] is None or edges[1] is None else _gap(np.array(edges)) / _gap(points[owners])
            if _GAP_RANGE[0] < share < _GAP_RANGE[1]:
                places[pair] = edges
                mixtures[pair] = [_blend_weights(lid, s, share) for lid in (_LIDS[side], _LIDS[side + 2])]
    return EyelidHelpers(places, mixtures)


def append_helpers(
    points: NDArray[np.float64], regions: Regions, margins: EyelidHelpers | None = None, /
) -> tuple[NDArray[np.float64], Regions]:
    """Return the control points (n, 3) followed by the helper points, and the regions for all of them."""
    margins = margins or helpers_on_parabola(points)
    fields = []
    for field in regions.fields:
        absent = [len(points) + i for i, owner in enumerate(HELPER_LIDS) if owner in field.excluded]
        fields.append(InfluenceField(field.weights, (*field.excluded, *absent)))
    return np.concatenate([points, margins.positions]), Regions(tuple(fields), regions.anchors)


def fold_helpers(matrix: NDArray[np.float32], margins: EyelidHelpers | None = None, /) -> NDArray[np.float32]:
    """Return the (V, n) operator of the control points from that of control and helper points, (V, n + h)."""
    own, helpers = np.split(matrix, [CONTROL_POINT_COUNT], axis=1)
    mixtures = PARABOLA_WEIGHTS if margins is None else margins.weights
    folded: NDArray[np.float32] = own + helpers @ mixtures.astype(np.float32)
    return folded


def _nearby(shells: LabelledMesh, places: NDArray[np.float64]) -> LabelledMesh:
    """Return the part of the shells that a column of rays near any of the places (h, 3) may meet."""
    corners = shells.vertices[shells.triangles][..., :2]
    low, high = places.min(axis=0)[:2] - _SEARCH_MARGIN, places.max(axis=0)[:2] + _SEARCH_MARGIN
    near = (corners.max(axis=1) > low).all(axis=1) & (corners.min(axis=1) < high).all(axis=1)
    return LabelledMesh(shells.vertices, shells.triangles[near], shells.triangle_labels[near])


def _gap(lids: NDArray[np.float64]) -> float:
    """Return how far an upper lid (2, 3) is above the lower."""
    return float(lids[0, 1] - lids[1, 1])


def _blend_weights(lid: str, s: float, share: float) -> NDArray[np.float64]:
    """Return the (n,) mixture of a helper point that goes with its lid by a share, with the corners for the rest."""
    row = np.zeros(CONTROL_POINT_COUNT)
    row[CONTROL_POINT_INDEX[lid]] = share
    row[CONTROL_POINT_INDEX[f"eye_outer_corner_{lid[-1]}"]] = (1 - share) * (1 - s) / 2
    row[CONTROL_POINT_INDEX[f"eye_inner_corner_{lid[-1]}"]] = (1 - share) * (1 + s) / 2
    return row


def _parabola_weights(lid: str, s: float) -> NDArray[np.float64]:
    row = _blend_weights(lid, s, 1 - s * s)
    row[CONTROL_POINT_INDEX[f"eye_outer_corner_{lid[-1]}"]] = s * (s - 1) / 2
    row[CONTROL_POINT_INDEX[f"eye_inner_corner_{lid[-1]}"]] = s * (s + 1) / 2
    return row


PARABOLA_WEIGHTS = np.array(
    [_parabola_weights(lid, s) for lid in _LIDS for s in _ARC_POSITIONS]
)  # (h, n) on the parabola
