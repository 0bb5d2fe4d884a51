"""Waters' muscles: the second deformer, for comparison with radial basis functions.

Strategy. A linear muscle is attached to the bone at A and ends in the skin at I. Contracted by C, it pulls the skin in
a cone around AI towards A: each vertex V by -C d AV, where d falls to zero towards the cone's angle and from radius S
to radius E. The offset is linear in C, so each muscle's offsets are computed once. A sphincter contracts an ellipse.
Several muscles must not move a vertex past its limits (Waters' "degree of freedom"): the length of their sum is limited
to the root of the sum of their squared lengths.
Source: Waters 1987; equations 4.16 to 4.19 of the thesis; Parke, Waters 1996 for the sphincter.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class LinearMuscle:
    """A muscle that pulls skin towards its root.

    root : (3,) A, on the bone, model units
    insertion : (3,) I, in the skin
    angle : alpha, radians from the axis to zero pull, at most pi
    start, end : S and E relative to |AI|: full pull up to S, none from E
    """

    root: NDArray[np.float64]
    insertion: NDArray[np.float64]
    angle: float = np.pi / 4
    start: float = 0.8
    end: float = 1.4

    def __post_init__(self) -> None:
        if not 0 < self.angle <= np.pi:
            raise ValueError(f"angle must be above 0 and at most pi, got {self.angle}")
        if not 0 <= self.start < self.end:
            raise ValueError(f"start and end must be 0 <= start < end, got {self.start} and {self.end}")
        if not np.linalg.norm(self.insertion - self.root) > 0:
            raise ValueError("root and insertion must differ")

    def falloff(self, vertices: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return d, (V,) from 0 to 1, of (V, 3) vertices: equations 4.17 to 4.19."""
        arms = vertices - self.root
        distance = np.linalg.norm(arms, axis=1)
        axis = self.insertion - self.root
        length = float(np.linalg.norm(axis))
        cosine = arms @ (axis / length) / np.maximum(distance, 1e-12 * length)
        limit = np.cos(self.angle)
        angular = np.clip((cosine - limit) / (1 - limit), 0.0, 1.0)
        s, e = self.start * length, self.end * length
        radial = np.cos(np.clip((distance - s) / (e - s), 0.0, 1.0) * np.pi / 2)
        return np.asarray(angular * radial * (distance < e))

    def offsets(self, vertices: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return the (V, 3) offsets of (V, 3) vertices for a contraction of 1: equation 4.16."""
        return np.asarray(-self.falloff(vertices)[:, None] * (vertices - self.root))


@dataclass(frozen=True)
class Sphincter:
    """A muscle that contracts an ellipse and protrudes it, as lips do in a kiss.

    centre : (3,) model units
    axes : (2, 3) half axes of the ellipse
    depth : half axis along the normal, model units
    protrusion : offset of the centre along the normal for a contraction of 1, model units
    """

    centre: NDArray[np.float64]
    axes: NDArray[np.float64]
    depth: float
    protrusion: float = 0.0

    def falloff(self, vertices: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return (V,): 1 at the centre, falling smoothly to 0 at the rim and beyond."""
        arms = vertices - self.centre
        lengths = np.linalg.norm(self.axes, axis=1)
        in_plane = arms @ (self.axes / lengths[:, None] ** 2).T
        along_normal = arms @ self._normal() / self.depth
        return np.asarray(np.clip(1 - (in_plane**2).sum(axis=1) - along_normal**2, 0.0, 1.0) ** 2)

    def offsets(self, vertices: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return the (V, 3) offsets of (V, 3) vertices for a contraction of 1."""
        arms = vertices - self.centre
        normal = self._normal()
        inwards = np.outer(arms @ normal, normal) - arms
        return np.asarray(self.falloff(vertices)[:, None] * (inwards + self.protrusion * normal))

    def _normal(self) -> NDArray[np.float64]:
        normal = np.cross(self.axes[0], self.axes[1])
        return np.asarray(normal / np.linalg.norm(normal))


class MuscleSet:
    """The muscles of one face: M names, and offsets (M, V, 3) float32, the vertex offsets for a contraction of 1."""

    def __init__(
        self,
        muscles: Mapping[str, LinearMuscle | Sphincter],
        vertices: NDArray[np.float64],
        weights: Mapping[str, NDArray[np.float64]] | None = None,
        /,
    ) -> None:
        """vertices : (V, 3); weights : muscle -> (V,) factor at each vertex, 1 without an entry."""
        weights = weights or {}
        self.names = tuple(muscles)
        offsets = [m.offsets(vertices) * np.reshape(weights.get(name, 1.0), (-1, 1)) for name, m in muscles.items()]
        self.offsets = np.array(offsets, np.float32).reshape(len(muscles), len(vertices), 3)

    def contract(self, contractions: Mapping[str, float], /) -> NDArray[np.float32]:
        """Return the (V, 3) float32 offsets of muscles that contract together.

        Offsets of one muscle, and of muscles that pull at right angles, are not reduced; those in one direction are.
        contractions : muscle -> 0 relaxed to 1 fully contracted
        Raises ValueError for an unknown muscle.
        """
        unknown = sorted(set(contractions) - set(self.names))
        if unknown:
            raise ValueError(f"contractions must be of {', '.join(self.names)}, got {', '.join(unknown)}")
        used = [self.names.index(name) for name in contractions]
        values = np.array(list(contractions.values()), np.float32)
        each = values[:, None, None] * self.offsets[used]
        total = each.sum(axis=0)
        limit = np.sqrt((each**2).sum(axis=(0, 2)))
        scale = np.minimum(1.0, limit / np.maximum(np.linalg.norm(total, axis=1), np.finfo(np.float32).tiny))
        return np.asarray(total * scale[:, None], np.float32)
