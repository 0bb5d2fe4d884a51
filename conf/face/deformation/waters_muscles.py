"""Waters' muscles: the second deformer, to compare with radial basis functions.

Strategy. A linear muscle is fixed to the bone at A and ends in the skin at I. Contracted by C, it pulls the skin
inside a cone about AI towards A: each vertex V by -C d AV, where d falls to nothing towards the cone's angle and from
a radius S to a radius E. All of it is linear in C, so each muscle's offsets are computed once. A sphincter draws an
ellipse together. Several muscles must not tear one vertex past its limits (Waters' "degree of freedom"): what they do
together never exceeds the root of the sum of their squares.
Source: Waters 1987; equations 4.16 to 4.19 of the thesis; Parke, Waters 1996 for the sphincter.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class LinearMuscle:
    """A muscle that pulls towards its root.

    root : (3,) A, on the bone, model units
    insertion : (3,) I, in the skin
    angle : alpha, radians from the axis to where the pull has gone, at most half a turn
    start, end : S and E as shares of |AI|: the pull is full up to S and has gone at E
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
            raise ValueError("root and insertion must be different places")

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
    """A muscle that draws an ellipse together and pushes it out, as lips do in a kiss.

    centre : (3,) model units
    axes : (2, 3) half axes of the ellipse, from the centre to its rim
    depth : how far from the plane of the axes it reaches, model units
    protrusion : how far out the centre goes for a contraction of 1, model units
    """

    centre: NDArray[np.float64]
    axes: NDArray[np.float64]
    depth: float
    protrusion: float = 0.0

    def falloff(self, vertices: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return (V,): 1 at the centre, falling smoothly to 0 at the rim and beyond."""
        arms = vertices - self.centre
        lengths = np.linalg.norm(self.axes, axis=1)
        across = arms @ (self.axes / lengths[:, None] ** 2).T
        ahead = arms @ self._normal() / self.depth
        inside = np.clip(1 - (across**2).sum(axis=1) - ahead**2, 0.0, 1.0)
        return np.asarray(inside**2)

    def offsets(self, vertices: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return the (V, 3) offsets of (V, 3) vertices for a contraction of 1."""
        arms = vertices - self.centre
        normal = self._normal()
        inwards = np.outer(arms @ normal, normal) - arms
        return np.asarray(self.falloff(vertices)[:, None] * (inwards + self.protrusion * normal))

    def _normal(self) -> NDArray[np.float64]:
        normal = np.cross(self.axes[0], self.axes[1])
        return np.asarray(normal / np.linalg.norm(normal))


@dataclass(frozen=True)
class MuscleSet:
    """Muscles on one face, ready to contract.

    names : M muscles
    offsets : (M, V, 3) float32, what each does to the vertices for a contraction of 1
    """

    names: tuple[str, ...]
    offsets: NDArray[np.float32] = field(repr=False)

    @classmethod
    def attach(
        cls,
        muscles: Mapping[str, LinearMuscle | Sphincter],
        vertices: NDArray[np.float64],
        /,
        *,
        shares: Mapping[str, NDArray[np.float64]] | None = None,
    ) -> "MuscleSet":
        """Compute what muscles do to the (V, 3) vertices.

        shares : muscle -> (V,) how far each vertex is its own; without an entry wholly
        """
        shares = shares or {}
        whole = np.ones(len(vertices))
        offsets = [m.offsets(vertices) * shares.get(name, whole)[:, None] for name, m in muscles.items()]
        return cls(tuple(muscles), np.array(offsets, np.float32).reshape(len(muscles), len(vertices), 3))

    def contract(self, contractions: Mapping[str, float], /) -> NDArray[np.float32]:
        """Return the (V, 3) float32 offsets of muscles that contract together.

        contractions : muscle -> 0 relaxed to 1 pulled all the way to its root
        Raises ValueError for a muscle that is not there.
        """
        unknown = sorted(set(contractions) - set(self.names))
        if unknown:
            raise ValueError(f"contractions must be of {', '.join(self.names)}, got {', '.join(unknown)}")
        used = [self.names.index(name) for name in contractions]
        strengths = np.array(list(contractions.values()), np.float32)
        return combine_limited(strengths[:, None, None] * self.offsets[used])


def combine_limited(offsets: NDArray[np.float32] | Sequence[NDArray[np.float32]], /) -> NDArray[np.float32]:
    """Return the (V, 3) sum of (M, V, 3) offsets, each vertex's no longer than the root of the sum of their squares.

    One muscle alone, and muscles that pull at right angles, add up; two that pull the same way do so by less.
    """
    each = np.asarray(offsets, np.float32)
    total = each.sum(axis=0)
    limit = np.sqrt((each**2).sum(axis=(0, 2)))
    length = np.linalg.norm(total, axis=1)
    scale = np.minimum(1.0, limit / np.maximum(length, np.finfo(np.float32).tiny))
    return np.asarray(total * scale[:, None], np.float32)
