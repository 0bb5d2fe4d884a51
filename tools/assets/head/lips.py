"""Close the lips: the base figure's part by a slit of half a millimetre, through which teeth would show."""

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.body import find_islands
from tools.assets.head.character import Character
from tools.assets.head.control_vertices import VERTICES
from tools.assets.head.edge_rings import edge_rings

_OVERLAP = 0.05  # cm: how far the lips reach past each other
_UPPER_SHARE = 0.6  # of the way that the upper lip comes down: its edge hides the lower lip's turned-in rim
_FALLOFF = np.array([1.0, 1.0, 0.85, 0.55, 0.25, 0.08])  # share of the lift by edge ring


def close_lips(character: Character) -> Character:
    """Move the inner rings of both lips until they meet."""
    islands = find_islands(character)
    ring = edge_rings(character, islands)[:, 0].astype(int)
    face = character.base.faces[islands.face]
    lower = _lower_side(character, face, ring)
    x, y, _ = character.vertices.T
    lips = (ring <= 5) & np.isin(np.arange(len(x)), face)
    seam_upper, seam_lower = (np.flatnonzero(lips & (ring == 1) & side) for side in (~lower, lower))
    seam_upper, seam_lower = (seam[np.argsort(np.abs(x[seam]))] for seam in (seam_upper, seam_lower))
    across = np.abs(x)
    gap = np.interp(across, across[seam_upper], y[seam_upper]) - np.interp(across, across[seam_lower], y[seam_lower])
    corner = across[VERTICES["inner_lip_corner_l"]]
    fade = np.clip((corner - across) / 0.15, 0, 1)
    way = np.clip(gap + _OVERLAP, 0, 0.2) * fade * _FALLOFF[np.clip(ring, 0, 5)] * lips
    vertices = character.vertices.copy()
    vertices[:, 1] += np.where(lower, (1 - _UPPER_SHARE) * way, -_UPPER_SHARE * way)
    return Character(character.base, vertices, character.shapes)


def _lower_side(character: Character, face: NDArray[np.int64], ring: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Tell which vertices belong to the lower lip, walking inwards from a ring where the lips are well apart."""
    y = character.vertices[:, 1]
    start = 6
    corner = y[VERTICES["outer_lip_corner_l"]]
    score = np.where(ring == start, np.sign(y - corner), 0.0)
    edges = np.concatenate([face[:, [i, (i + 1) % 4]] for i in range(4)])
    edges = np.concatenate([edges, edges[:, ::-1]])
    for inner in range(start - 1, -1, -1):
        across = (ring[edges[:, 0]] == inner + 1) & (ring[edges[:, 1]] == inner)
        np.add.at(score, edges[across, 1], np.sign(score[edges[across, 0]]))
    return np.asarray(score < 0)
