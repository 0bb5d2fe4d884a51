"""Edge loops around the mouth and the eyes: how many edges lie between a vertex and the lip contact or the lid."""

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.body import Islands
from tools.assets.head.character import Character

FAR = 40.0


def edge_rings(character: Character, islands: Islands) -> NDArray[np.float64]:
    """Return (V, 2): edges from each vertex of the face to the mouth bag, and to the nearer eye socket."""
    faces = character.base.faces
    face = faces[islands.face]
    body = character.base.groups == "body"
    other = faces[body & ~islands.face & ~islands.mouth]
    socket = np.unique(other)
    centre = character.vertices[socket]
    socket = socket[(np.abs(centre[:, 0]) < 5.2) & (centre[:, 1] > 0) & (centre[:, 2] > 0)]
    seeds = np.intersect1d(face, faces[islands.mouth]), np.intersect1d(face, socket)
    return np.stack([_walk(face, seed, len(character.vertices)) for seed in seeds], axis=1)


def _walk(faces: NDArray[np.int64], seed: NDArray[np.int64], count: int) -> NDArray[np.float64]:
    edges = np.concatenate([faces[:, [i, (i + 1) % 4]] for i in range(4)])
    rings = np.full(count, FAR)
    rings[seed] = 0
    for ring in range(1, 30):
        for a, b in (edges.T, edges.T[::-1]):
            next_ones = b[(rings[a] == ring - 1) & (rings[b] == FAR)]
            rings[next_ones] = ring
    return rings
