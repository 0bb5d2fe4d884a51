"""Regions of influence: separate upper and lower lips, and upper and lower eyelids.

Strategy. Points of the upper and the lower lip nearly touch and move apart; one interpolation of both would vary
extremely between them. So the mouth has two fields: the upper one excludes the lower lip's points, the lower one the
upper lip's. Each vertex blends the two by its distances along the surface to either lip: what lies next to the upper
lip along the skin follows the upper lip, though the lower one may be closer through the air. The same holds for the
lids, so there are four fields.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import LOWER_LID, LOWER_LIP, PUPILS, UPPER_LID, UPPER_LIP, control_point_indices
from conf.face.interpolation import smoothstep
from conf.face.mesh.surface_graph import SurfaceGraph

# In eye distances along the surface: how far lips and lids separate it.
_MOUTH_REACH, _EYE_REACH = 1.0, 0.6
_FADE_FRACTION = 0.3  # of the reach, over which the separation ends
_CONTACT_DISTANCE = 0.02  # eye distances: nearer lips touch
_INNER_UPPER, _INNER_LOWER = control_point_indices("inner_lip_upper"), control_point_indices("inner_lip_lower")
_OUTER_UPPER = control_point_indices("outer_lip_upper", "cupids_bow")
_OUTER_LOWER = control_point_indices("outer_lip_lower")
_SKIN_TOLERANCE = 0.05  # eye distances by which the skin may be farther than the nearest vertex


@dataclass(frozen=True)
class InfluenceField:
    """One interpolation among several.

    weights : (V,) float64, of this field at each vertex
    excluded : control points that do not act in it
    """

    weights: NDArray[np.float64]
    excluded: tuple[int, ...]


@dataclass(frozen=True)
class Regions:
    """Where each control point acts.

    fields : interpolations; their weights add up to one at every vertex
    anchors : (k, 3) positions, model units, that every field holds still
    """

    fields: tuple[InfluenceField, ...]
    anchors: NDArray[np.float64]

    @classmethod
    def unrestricted(cls, vertex_count: int, /, anchors: NDArray[np.float64] | None = None) -> "Regions":
        """Return one field: every control point acts everywhere."""
        return cls((InfluenceField(np.ones(vertex_count), ()),), np.empty((0, 3)) if anchors is None else anchors)

    def excluding(self, points: Sequence[int], /) -> "Regions":
        """Return the same regions without the influence of some control points."""
        fields = tuple(InfluenceField(field.weights, (*field.excluded, *points)) for field in self.fields)
        return replace(self, fields=fields)


def split_regions(surface: SurfaceGraph, points: NDArray[np.float64], /, *, anchors: NDArray[np.float64]) -> Regions:
    """Return the four fields of a face.

    surface : of the mesh; distances are measured along it
    points : (n, 3) control points on it, model units
    anchors : (k, 3) model units
    """
    eye_distance = float(np.linalg.norm(points[PUPILS[0]] - points[PUPILS[1]]))
    seeds = surface.nearest_vertices(points, tolerance=_SKIN_TOLERANCE * eye_distance)
    _separate_inner_lips(surface, points, seeds, eye_distance)
    parents = surface.parent_vertices(seeds)
    mouth = _lower_weight(surface, seeds, (UPPER_LIP, LOWER_LIP), _MOUTH_REACH * eye_distance)[parents]
    eyes = _lower_weight(surface, seeds, (UPPER_LID, LOWER_LID), _EYE_REACH * eye_distance)[parents]
    return Regions(blend_fields(mouth, eyes), anchors)


def blend_fields(mouth: NDArray[np.float64], eyes: NDArray[np.float64], /) -> tuple[InfluenceField, ...]:
    """Return the four fields for the (V,) weights of the lower lip and of the lower lids: 0 upper, 1 lower."""
    lips, lids = ((1 - mouth, LOWER_LIP), (mouth, UPPER_LIP)), ((1 - eyes, LOWER_LID), (eyes, UPPER_LID))
    return tuple(InfluenceField(m * e, (*lip, *lid)) for m, lip in lips for e, lid in lids)


def _separate_inner_lips(
    surface: SurfaceGraph, points: NDArray[np.float64], seeds: NDArray[np.intp], eye_distance: float
) -> None:
    """Move the seeds of the inner lips to their own lip, in place.

    Where lips touch, the vertex nearest to a point may be the other lip's. The outer lips do not touch: distances to
    them along the surface tell the lips apart.
    """
    reach = _MOUTH_REACH * eye_distance
    upper, lower = (surface.distances(seeds[lip], limit=reach) for lip in (_OUTER_UPPER, _OUTER_LOWER))
    for lip, own, other in ((_INNER_UPPER, upper, lower), (_INNER_LOWER, lower, upper)):
        for point in lip:
            near = surface.vertices_within(points[point], tolerance=_CONTACT_DISTANCE * eye_distance)
            seeds[point] = near[np.argmin(own[near] - other[near])]


def _lower_weight(
    surface: SurfaceGraph, seeds: NDArray[np.intp], groups: tuple[list[int], list[int]], reach: float
) -> NDArray[np.float64]:
    """Return the (V,) weight of the lower field: 0 next to the upper group, 1 next to the lower, smooth between.

    Beyond the reach of both it fades to 0: the skull belongs to the upper field.
    """
    upper, lower = (surface.distances(seeds[group], limit=reach) for group in groups)
    weight = smoothstep(0.5 + 0.9 * (upper - lower) / np.maximum(upper + lower, 1e-9 * reach))
    return weight * smoothstep((reach - np.minimum(upper, lower)) / (_FADE_FRACTION * reach))
