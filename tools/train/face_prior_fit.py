"""Compute a face prior from heads with known control points."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.fitting.face_prior import (
    DEPTH_MIRROR_INDICES,
    OBSERVED_MIRROR_INDICES,
    STABLE_POINTS,
    FacePrior,
    depth_residuals,
    sample_depths,
)
from conf.face.mesh.winding import triangle_normals
from conf.face.similarity import fit_similarity
from conf.face.symmetry import MIRROR_INDICES

_MIRROR = np.array([-1.0, 1.0, 1.0])


@dataclass(frozen=True)
class TrainingHead:
    """A head with known control points, in a frame of its own.

    observed : (m, 3) tracked landmarks
    truth, normals : (n, 3) control points, and surface normals there
    vertices, triangles : (V, 3), (F, 3) the mesh
    """

    observed: NDArray[np.float64]
    truth: NDArray[np.float64]
    normals: NDArray[np.float64]
    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]


def train_prior(heads: Sequence[TrainingHead], /, *, ridge: float) -> FacePrior:
    """Return the prior of N heads, all lit from one side; residuals from the mean count twice, also mirrored.

    ridge : lambda, cm^2; the larger, the more the observation is trusted and the less the regression corrects it
    """
    mean_observed = np.mean([head.observed for head in heads], axis=0)
    for _ in range(3):
        frames = [fit_similarity(head.observed[STABLE_POINTS], mean_observed[STABLE_POINTS]) for head in heads]
        observed = np.array([f.apply(head.observed) for f, head in zip(frames, heads, strict=True)])
        mean_observed = observed.mean(axis=0)
    truth = np.array([f.apply(head.truth) for f, head in zip(frames, heads, strict=True)])
    sampled = np.array([sample_depths(f.apply(h.vertices), h.triangles) for f, h in zip(frames, heads, strict=True)])
    depths = np.nanmedian(np.concatenate([sampled, sampled[:, DEPTH_MIRROR_INDICES]]), axis=0)
    depth_rows, mean = depth_residuals(sampled, depths), truth.mean(axis=0)
    residuals = _with_mirror(observed - mean_observed, OBSERVED_MIRROR_INDICES)
    target = _with_mirror(truth - mean, MIRROR_INDICES)
    errors = (target - residuals[:, : mean.shape[0]]).reshape(len(target), -1)
    depth_rows = np.concatenate([depth_rows, depth_rows[:, DEPTH_MIRROR_INDICES]])
    features = np.hstack([residuals.reshape(len(target), -1), depth_rows])
    system = features.T @ features + ridge * np.eye(features.shape[1])
    correction = np.asarray(np.linalg.solve(system, features.T @ errors), dtype=np.float64)
    normals = np.array([h.normals @ f.rotation.T for f, h in zip(frames, heads, strict=True)]).mean(axis=0)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return FacePrior(mean_observed, mean, depths, correction, np.asarray(normals))


def nearest_normals(
    points: NDArray[np.float64], vertices: NDArray[np.float64], triangles: NDArray[np.int32]
) -> NDArray[np.float64]:
    """Return the (n, 3) unit normal of the surface at the vertex nearest to each point (n, 3)."""
    normals = triangle_normals(vertices, triangles)
    used = np.unique(triangles)
    nearest = used[[np.linalg.norm(vertices[used] - point, axis=1).argmin() for point in points]]
    sums = np.array([normals[(triangles == vertex).any(axis=1)].sum(axis=0) for vertex in nearest])
    return np.asarray(sums / np.linalg.norm(sums, axis=1, keepdims=True))


def _with_mirror(points: NDArray[np.float64], mirror_indices: list[int] | NDArray[np.intp]) -> NDArray[np.float64]:
    return np.concatenate([points, points[:, mirror_indices] * _MIRROR])
