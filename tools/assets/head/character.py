"""Who the default head is: a mixture of the base figure's targets, scaled to 6.4 cm between the eyes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.alignment import align
from tools.assets.head.control_vertices import VERTICES
from tools.assets.head.source import BaseMesh, Source

ES0_CM = 6.4

_SEX = {"male": 0.62, "female": 0.38}
_ORIGIN = {"caucasian": 0.62, "asian": 0.23, "african": 0.15}
_DETAILS = {
    "eyes/l-eye-scale-incr": 0.25,
    "eyes/r-eye-scale-incr": 0.25,
    "mouth/mouth-angles-up": 0.18,
    "head/head-scale-vert-decr": 0.15,
    "neck/neck-scale-horiz-decr": 0.1,
}


@dataclass(frozen=True)
class Character:
    """The figure in model centimetres (origin between the eyes) with its 52 shapes.

    base : topology; vertices : (V, 3); shapes : name -> (V, 3) offsets
    """

    base: BaseMesh
    vertices: NDArray[np.float64]
    shapes: dict[str, NDArray[np.float64]]

    def eye_helper(self, side: str) -> NDArray[np.float64]:
        """Return the vertices of the eyeball guide of side "l" or "r"."""
        return self.vertices[self.base.members(f"helper-{side}-eye")]


def build_character(source: Source) -> Character:
    """Mix the targets and scale the figure so that its eye centres lie 6.4 cm apart."""
    base = source.read_base()
    count = len(base.vertices)
    mixed = base.vertices.copy()
    for name, weight in _weights().items():
        mixed += weight * source.read_target(name, count)
    left, right = (mixed[base.members(f"helper-{side}-eye")].mean(axis=0) for side in "lr")
    scale = ES0_CM / np.linalg.norm(left - right)
    shapes = {name: offsets * scale for name, offsets in source.read_face_units(count).items()}
    return Character(base, (mixed - (left + right) / 2) * scale, shapes)


def _weights() -> dict[str, float]:
    weights = dict(_DETAILS)
    for sex, share in _SEX.items():
        for origin, part in _ORIGIN.items():
            weights[f"macrodetails/{origin}-{sex}-young"] = share * part
        weights[f"macrodetails/universal-{sex}-young-averagemuscle-averageweight"] = share
    return weights


def align_to_canonical(character: Character) -> Character:
    """Move the figure to where the tracker's canonical face lies."""
    points = {name: character.vertices[index] for name, index in VERTICES.items()}
    rotation, shift = align(points)
    shapes = {name: offsets @ rotation.T for name, offsets in character.shapes.items()}
    return Character(character.base, character.vertices @ rotation.T + shift, shapes)
