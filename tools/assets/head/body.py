"""Extract face, neck, mouth cavity and tongue from the base figure; count edge loops around mouth and eyes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.character import Character
from tools.assets.head.part import FRAMES, Part
from tools.assets.head.shirt import angle_below_collar
from tools.assets.head.unwrap import spread_face

# Islands of the base mesh's texture layout: (lowest u, v, highest u, v) of a face's centre.
_FACE_ISLAND = (0.63, 0.145, 1.0, 0.83)
_MOUTH_ISLAND = (0.755, 0.0, 0.925, 0.145)
_TUCKED = 5.0  # degrees of the neck that are hidden below the collar


@dataclass(frozen=True)
class Islands:
    """Faces of the base mesh by body part: boolean masks (F,)."""

    face: NDArray[np.bool_]
    mouth: NDArray[np.bool_]
    neck: NDArray[np.bool_]
    tongue: NDArray[np.bool_]


def find_islands(character: Character) -> Islands:
    """Classify the faces of the head; the eye sockets behind the eyeballs are in none of the masks."""
    base = character.base
    centre = character.canonical[base.faces].mean(axis=1)
    uv = base.uvs[base.face_uvs].mean(axis=1)
    body = base.groups == "body"
    near = body & (np.abs(centre[:, 0]) < 13.0) & (centre[:, 1] > -17.0)
    face = near & _inside(uv, _FACE_ISLAND)
    mouth = near & _inside(uv, _MOUTH_ISLAND)
    socket = near & (uv[:, 0] < 0.16) & (uv[:, 1] > 0.5) & (uv[:, 1] < 0.7)
    trunk = body & ~face & ~mouth & ~socket & (centre[:, 1] > -25.0)
    neck = trunk & (angle_below_collar(centre) < _TUCKED)
    return Islands(face, mouth, neck, base.groups == "helper-tongue")


def _inside(uv: NDArray[np.float64], box: tuple[float, float, float, float]) -> NDArray[np.bool_]:
    return np.asarray(((uv > box[:2]) & (uv < box[2:])).all(axis=1))


def build_body(character: Character) -> tuple[Part, NDArray[np.int64]]:
    """Build groups skin, mouth and tongue.

    Returns the part and, for each of its vertices, the (V,) index of the vertex in the base mesh.
    """
    base = character.base
    islands = find_islands(character)
    masks = {"face": islands.face, "neck": islands.neck, "mouth": islands.mouth, "tongue": islands.tongue}
    origin = np.unique(base.faces[np.any(list(masks.values()), axis=0)])
    renumber = np.full(len(base.vertices), -1)
    renumber[origin] = np.arange(len(origin))
    uvs: list[NDArray[np.float64]] = []
    corners: dict[str, NDArray[np.int64]] = {}
    for name, mask in masks.items():
        used, compact = np.unique(base.face_uvs[mask], return_inverse=True)
        first = sum(len(u) for u in uvs)
        uvs.append(FRAMES[name].map_into(_unwrap(name, character, mask, used)))
        corners[name] = np.stack([renumber[base.faces[mask]], compact.reshape(-1, 4) + first], axis=-1)
    groups = {
        "skin": np.concatenate([corners["face"], corners["neck"]]),
        "mouth": corners["mouth"],
        "tongue": corners["tongue"],
    }
    shapes = np.stack([offsets[origin] for offsets in character.shapes.values()])
    return Part(character.vertices[origin], shapes, np.concatenate(uvs), groups), origin


def _unwrap(name: str, character: Character, mask: NDArray[np.bool_], used: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the used texture coordinates, scaled to the unit square."""
    base = character.base
    flat = base.uvs[used]
    if name == "face":  # the island is rotated by 90 degrees
        flat = spread_face(np.stack([flat[:, 1], -flat[:, 0]], axis=1), _feature_uvs(character, mask, used))
    if name == "neck":
        flat = _unwrap_neck(character, mask, used)
    low, high = flat.min(axis=0), flat.max(axis=0)
    return np.asarray((flat - low) / (high - low))


def _feature_uvs(
    character: Character, mask: NDArray[np.bool_], used: NDArray[np.int64]
) -> dict[str, NDArray[np.int64]]:
    """Return indices of the used texture coordinates of eyes, mouth and ears, by name."""
    base = character.base
    position = np.zeros((len(base.uvs), 3))
    position[base.face_uvs[mask]] = character.canonical[base.faces[mask]]
    x, y, z = position[used].T
    features = {"mouth": (np.hypot(x / 2.6, (y + 4.3) / 1.2) < 1) & (z > 3)}
    for side, sign in (("l", 1.0), ("r", -1.0)):
        features[f"eye_{side}"] = (np.hypot((x * sign - 3.2) / 1.7, (y - 2.7) / 0.7) < 1) & (z > 1)
        features[f"ear_{side}"] = (x * sign > 8.2) & (np.abs(y) < 4)
    return {name: np.flatnonzero(chosen) for name, chosen in features.items()}


def _unwrap_neck(character: Character, mask: NDArray[np.bool_], used: NDArray[np.int64]) -> NDArray[np.float64]:
    """Unwrap the neck around a vertical axis; the base mesh has a seam at its back."""
    base = character.base
    position = np.zeros((len(base.uvs), 3))
    position[base.face_uvs[mask]] = character.canonical[base.faces[mask]]
    x, y, z = position[used].T
    lateral = np.zeros(len(base.uvs))
    lateral[base.face_uvs[mask]] = character.canonical[base.faces[mask]].mean(axis=1)[:, :1]
    angle = np.arctan2(x, z + 6.0)
    back = (np.abs(x) < 0.01) & (z < -6.0)
    angle[back] = np.pi * np.sign(lateral[used][back])
    return np.stack([angle, y], axis=1)


FAR = 40.0


def edge_rings(character: Character, islands: Islands) -> NDArray[np.float64]:
    """Return (V, 2): number of edges from each vertex of the face to the mouth cavity and to the nearer eye socket."""
    faces = character.base.faces
    face = faces[islands.face]
    body = character.base.groups == "body"
    other = faces[body & ~islands.face & ~islands.mouth]
    socket = np.unique(other)
    centre = character.canonical[socket]
    socket = socket[(np.abs(centre[:, 0]) < 5.2) & (centre[:, 1] > 0) & (centre[:, 2] > 0)]
    seeds = np.intersect1d(face, faces[islands.mouth]), np.intersect1d(face, socket)
    return np.stack([_edge_distances(face, seed, len(character.vertices)) for seed in seeds], axis=1)


def _edge_distances(faces: NDArray[np.int64], seed: NDArray[np.int64], count: int) -> NDArray[np.float64]:
    edges = np.concatenate([faces[:, [i, (i + 1) % 4]] for i in range(4)])
    rings = np.full(count, FAR)
    rings[seed] = 0
    for ring in range(1, 30):
        for a, b in (edges.T, edges.T[::-1]):
            next_vertices = b[(rings[a] == ring - 1) & (rings[b] == FAR)]
            rings[next_vertices] = ring
    return rings
