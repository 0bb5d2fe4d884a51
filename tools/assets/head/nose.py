"""Soften the groove beside the wings of the nose: the mixed targets leave a sharp ridge there that shines."""

import numpy as np

from tools.assets.head.body import find_islands
from tools.assets.head.character import Character
from tools.assets.head.control_vertices import VERTICES

_OUTWARD = np.array([0.22, -0.05, -0.3])  # cm from the wing's control point to the ridge, left side
_REACH = 0.55  # cm
_ROUNDS, _STEP = 12, 0.5


def soften_nose_wings(character: Character) -> Character:
    """Return the character with the ridges smoothed towards the mean of their neighbours."""
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
    return Character(character.base, vertices, character.shapes)
