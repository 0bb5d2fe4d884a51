"""Find the eyeballs of a face, and the shells that cover them, by their shapes.

Strategy. An eyeball is a component behind a pupil that fits a sphere. Sculpted heads put open shells on it: tear film,
shadow of the lids, lashes. They are meant to be drawn with a transparent texture; without one they hide the eye.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conf.face.mesh.surface_graph import component_labels, triangle_edges

# Model centimetres, 6.4 between the pupils; a human eyeball has a radius of 1.2.
_RADIUS = (0.7, 2.4)
_MAX_OFFSET = 1.2  # from the centre of an eyeball's bounding box to the line of sight through its pupil
# Relative to the radius of the eyeball.
_MIN_WIDTH = 1.2  # of its bounding box: a strip along a lid also fits a sphere
_MAX_SPHERE_ERROR = 0.12  # root mean square distance of its vertices from the sphere
_PUPIL_DEPTH = (0.6, 1.5)  # from its centre to its pupil
_IRIS_RADIUS = 1.12  # iris and cornea, components of their own within this radius, belong to it
_MAX_AXIS_OFFSET = 0.3  # from its axis to the middle of its white, its iris or its cornea
_COVER_RADIUS = 2.2  # from its centre to the tips of the lashes


class Components(NamedTuple):
    """The bounding boxes of the components, (C, 3) each, and the vertices sorted by component."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    vertices: NDArray[np.float64]
    starts: NDArray[np.intp]

    @classmethod
    def of(cls, vertices: NDArray[np.float64], labels: NDArray[np.int32]) -> "Components":
        """Sort vertices (V, 3) by their component, (V,)."""
        order = np.argsort(labels, kind="stable")
        starts = np.searchsorted(labels[order], np.arange(labels.max() + 2))
        vertices = vertices[order]
        low, high = (extreme.reduceat(vertices, starts[:-1]) for extreme in (np.minimum, np.maximum))
        return cls(low, high, vertices, starts)

    def members(self, label: int) -> NDArray[np.float64]:
        """Return the (k, 3) vertices of one component."""
        return self.vertices[self.starts[label] : self.starts[label + 1]]


class Eyeball(NamedTuple):
    """An eyeball: (3,) its centre, its radius and the components that it is made of."""

    centre: NDArray[np.float64]
    radius: float
    components: list[int]


def find_eyeball(components: Components, pupil: NDArray[np.float64], assigned: set[int]) -> Eyeball | None:
    """Return the eyeball behind a pupil (3,), or None. assigned : components that are something else."""
    centres, extent = (components.low + components.high) / 2, components.high - components.low
    near = np.linalg.norm(centres[:, :2] - pupil[:2], axis=1) < _MAX_OFFSET
    near &= (extent[:, :2] > _RADIUS[0]).all(axis=1) & (extent < 2 * _RADIUS[1]).all(axis=1)
    best: tuple[float, NDArray[np.float64], int] | None = None
    for label in np.flatnonzero(near).tolist():
        if label in assigned:
            continue
        centre, radius, error = fit_sphere(components.members(label))
        depth = np.linalg.norm(pupil - centre) / radius
        fits = _RADIUS[0] < radius < _RADIUS[1] and error < _MAX_SPHERE_ERROR * radius and centre[2] < pupil[2]
        fits = fits and extent[label, :2].min() > _MIN_WIDTH * radius
        if fits and _PUPIL_DEPTH[0] < depth < _PUPIL_DEPTH[1] and (best is None or radius > best[0]):
            best = radius, centre, label
    if best is None:
        return None
    radius, centre, label = best
    own = {label, *_within(components, centre, _IRIS_RADIUS * radius, assigned)}  # an ellipsoid is not within
    return Eyeball(centre, radius, sorted(own))


def without_eye_covers(
    vertices: NDArray[np.float64], triangles: NDArray[np.int32], pupils: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Return (F,) which triangles are not of open shells in front of an eyeball.

    vertices : (V, 3); triangles : (F, 3); pupils : (k, 3); upright, in model centimetres
    """
    labels = component_labels(triangle_edges(triangles), len(vertices))
    components = Components.of(vertices, labels)
    is_open = _open_components(triangles, labels)
    skin = int(np.bincount(labels).argmax())
    covers: list[int] = []
    for pupil in pupils:
        eyeball = find_eyeball(components, pupil, {skin})
        if eyeball is not None:
            near = _within(components, eyeball.centre, _COVER_RADIUS * eyeball.radius, {skin, *eyeball.components})
            near += [label for label in eyeball.components if not _is_centred(components.members(label), eyeball)]
            covers += [i for i in near if is_open[i] and components.low[i, 2] > eyeball.centre[2]]
    return ~np.isin(labels[triangles[:, 0]], covers)


def fit_sphere(vertices: NDArray[np.float64]) -> tuple[NDArray[np.float64], float, float]:
    """Return centre (3,), radius and root mean square error of the linear least-squares sphere of vertices (k, 3)."""
    mean = vertices.mean(axis=0)
    offsets = vertices - mean
    system = np.column_stack([2 * offsets, np.ones(len(offsets))])
    solution = np.linalg.lstsq(system, (offsets**2).sum(axis=1), rcond=None)[0]
    radius = float(np.sqrt(max(solution[3] + solution[:3] @ solution[:3], 1e-12)))
    errors = np.linalg.norm(offsets - solution[:3], axis=1) - radius
    return mean + solution[:3], radius, float(np.sqrt((errors**2).mean()))


def _within(components: Components, centre: NDArray[np.float64], reach: float, assigned: set[int]) -> list[int]:
    """Return the components, apart from those assigned, all of whose vertices are within reach of a centre (3,)."""
    corners = np.linalg.norm(np.maximum(np.abs(components.low - centre), np.abs(components.high - centre)), axis=1)
    inside = set(np.flatnonzero(corners < 2 * reach).tolist()) - assigned  # corners of a ball's box: sqrt(3) radii
    return [i for i in sorted(inside) if np.linalg.norm(components.members(i) - centre, axis=1).max() < reach]


def _is_centred(vertices: NDArray[np.float64], eyeball: Eyeball) -> bool:
    """Tell whether vertices (k, 3) lie around the axis of an eyeball, as its white, iris and cornea do."""
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    return float(np.linalg.norm((middle - eyeball.centre)[:2])) < _MAX_AXIS_OFFSET * eyeball.radius


def _open_components(triangles: NDArray[np.int32], labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Return (C,) which components have an edge with a triangle on one side only."""
    edges = np.sort(triangle_edges(triangles), axis=1).astype(np.int64)
    keys, counts = np.unique(edges[:, 0] * len(labels) + edges[:, 1], return_counts=True)
    is_open = np.zeros(int(labels.max()) + 1, dtype=np.bool_)
    is_open[labels[keys[counts == 1] // len(labels)]] = True
    return is_open
