"""Correct flaws of the blended figure: the slit between the lips, a ridge beside the nose, a neck unlike the shirt."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.body import edge_rings, find_islands
from tools.assets.head.character import Character
from tools.assets.head.control_vertices import VERTICES

_OVERLAP = 0.05  # of the closed lips, cm
_UPPER_WEIGHT = 0.6  # fraction of the gap that the upper lip moves, so that it hides the inner rim of the lower lip
_FALLOFF = np.array([1.0, 1.0, 0.85, 0.55, 0.25, 0.08])  # weight of the motion by edge loop


def close_lips(character: Character) -> Character:
    """Return the character with the inner edge loops of both lips moved until they meet.

    The base figure has a gap of 0.5 mm between the lips, through which the teeth would be visible.
    """
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
    distance = np.clip(gap + _OVERLAP, 0, 0.2) * fade * _FALLOFF[np.clip(ring, 0, 5)] * lips
    vertices = character.vertices.copy()
    vertices[:, 1] += np.where(lower, (1 - _UPPER_WEIGHT) * distance, -_UPPER_WEIGHT * distance)
    return replace(character, vertices=vertices)


def _lower_side(character: Character, face: NDArray[np.int64], ring: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return (V,) bool, the vertices of the lower lip, propagated inwards from a loop where the lips are apart."""
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


_OUTWARD = np.array([0.22, -0.05, -0.3])  # cm from the wing's control point to the ridge, left side
_REACH = 0.55  # cm
_ROUNDS, _STEP = 12, 0.5


def soften_nose_wings(character: Character) -> Character:
    """Return the character with the ridges beside the wings of the nose smoothed (Laplacian).

    The blended targets leave a sharp ridge there, which causes a highlight.
    """
    faces = character.base.faces[find_islands(character).face]
    edges = np.concatenate([faces[:, [i, (i + 1) % 4]] for i in range(4)])
    edges = np.unique(np.concatenate([edges, edges[:, ::-1]]), axis=0)
    vertices = character.vertices.copy()
    weight = np.zeros(len(vertices))
    for side, mirror in (("l", 1.0), ("r", -1.0)):
        centre = vertices[VERTICES[f"nostril_border_{side}"]] + _OUTWARD * [mirror, 1, 1]
        weight += np.exp(-((np.linalg.norm(vertices - centre, axis=1) / _REACH) ** 2))
    weight[weight < 0.05] = 0
    degree = np.maximum(np.bincount(edges[:, 0], minlength=len(vertices)), 1)[:, None]
    for _ in range(_ROUNDS):
        mean = np.zeros_like(vertices)
        np.add.at(mean, edges[:, 0], vertices[edges[:, 1]])
        vertices += _STEP * weight[:, None] * (mean / degree - vertices)
    return replace(character, vertices=vertices)


_OWN_NECK, _DEFAULT_NECK = -10.5, -16.0  # heights between which the neck changes to that of the default head, cm
NECK_AXIS = -6.0  # z, cm


def fit_neck(character: Character, shoulders: float) -> Character:
    """Return the character with neck and shoulders of the default head, scaled, so that the shirt fits.

    shoulders : width relative to the default head's
    """
    if character.layout is None:
        return character
    height = character.layout[:, 1]
    own = np.clip((height - _DEFAULT_NECK) / (_OWN_NECK - _DEFAULT_NECK), 0, 1)
    own = (own * own * (3 - 2 * own))[:, None]
    default = (character.layout - [0, 0, NECK_AXIS]) * [shoulders, 1, shoulders] + [0, 0, NECK_AXIS]
    body = np.isin(np.arange(len(height)), character.base.members("body"))[:, None]
    return replace(
        character, vertices=np.where(body, default + own * (character.vertices - default), character.vertices)
    )
