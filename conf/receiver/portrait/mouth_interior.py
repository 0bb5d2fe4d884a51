"""Predict the inside of a mouth that is open wider than in the images shown: teeth, a dark gap and the tongue.

Teeth are white in the light that falls on the person, estimated from the skin below the eyes; tongue and gums have the
colour of the lips in the mouth's shadow. Upper teeth move with the upper lip, the tongue with the lower one.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.interpolation import smoothstep
from conf.face.portrait import contours
from conf.face.portrait.lip_lid_gaps import OPENINGS, Opening, height_at
from conf.face.portrait.warp import PortraitWarp
from conf.receiver.portrait.textured_grid import grid_triangles, to_linear, to_srgb

# Heights are of the length of the mouth's opening, downwards from the upper lip.
TEETH_HEIGHT = 0.15
MAX_TEETH = 0.55  # of the opening: below it there is the tongue or the lower lip's shadow
TEETH_LIGHT = 0.75  # of the skin's luminance
TEETH_SATURATION = 0.75  # of the skin's: the light has a colour too
UPPER_SHADOW = 0.45  # of the teeth's brightness just below the lip
CORNER_SHADOW = 0.2  # the same at the corners of the mouth
GAP_LIGHT = 0.06  # of the lips' luminance: between the teeth
TONGUE_LIGHT = 0.5  # the same of the tongue
TONGUE_SATURATION = 1.3  # of the lips'
EDGE_FADE = 0.12  # of the opening's height, over which its edge fades
CORNER_FADE = 0.1  # of its length
SIZE = (32, 32)  # width and height of the texture, px
_COLUMNS = np.linspace(0, 1, 17)
_ROWS = 7  # of the grid; the teeth end at the middle one
TEETH_END, TEETH_FADE = 0.5, 0.12  # of the texture's height
_LIPS = OPENINGS[0]
_LUMA = np.array([0.0722, 0.7152, 0.2126])  # of linear BGR. Source: ITU-R BT.709.
# Pairs of the tracker's landmarks: half-way from the lower lids to the corners of the mouth, and in the lips' red.
_CHEEKS = ((145, 61), (374, 291))
_LIP_PAIRS = ((14, 17), (13, 0), (87, 84), (317, 314))


@dataclass(frozen=True)
class MouthInterior:
    """A textured grid of k vertices between the lips.

    colours : (h, w, 3) uint8 BGR; alpha : (h, w) uint8; uvs : (k, 2) texture coordinates; triangles : (F, 3)
    """

    colours: NDArray[np.uint8]
    alpha: NDArray[np.uint8]
    uvs: NDArray[np.float64]
    triangles: NDArray[np.int32]

    def grid(self, positions: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return the grid's vertices (k, 2) between the lips of the deformed mesh (V, 2)."""
        opening = Opening.between(positions[_LIPS[0]], positions[_LIPS[1]])
        x = _COLUMNS * opening.length
        upper, lower = height_at(opening.upper, x), height_at(opening.lower, x)
        gap = np.maximum(upper - lower, 0)
        teeth = np.minimum(TEETH_HEIGHT * opening.length, MAX_TEETH * gap)
        first, second = np.linspace(0, 1, _ROWS // 2 + 1)[:, None], np.linspace(0, 1, _ROWS // 2 + 1)[1:, None]
        heights = upper - np.concatenate([first * teeth, teeth + second * (gap - teeth)])
        points = opening.origin + x[:, None] * opening.along + heights[..., None] * opening.up
        return np.asarray(points.reshape(-1, 2))


def predict_mouth_interior(photo: NDArray[np.uint8], warp: PortraitWarp, /) -> MouthInterior:
    """Return the inside of the mouth of a photo (H, W, 3) uint8 BGR."""
    light = to_linear(photo)
    skin, lips = (_mean_colour(light, warp, pairs) for pairs in (_CHEEKS, _LIP_PAIRS))
    teeth = TEETH_LIGHT * _saturate(skin, TEETH_SATURATION)
    lips = np.clip(_saturate(lips, TONGUE_SATURATION), 0, 1)
    width, height = SIZE
    t = np.linspace(0, 1, width)
    v = np.linspace(0, 1, height)[:, None]
    to_middle = smoothstep(np.minimum(t, 1 - t) / 0.35)
    shade = (UPPER_SHADOW + (1 - UPPER_SHADOW) * smoothstep(v / 0.3)) * (
        CORNER_SHADOW + (1 - CORNER_SHADOW) * to_middle
    )
    tooth_weight = (smoothstep((TEETH_END - v) / TEETH_FADE) * to_middle)[..., None]
    tongue = GAP_LIGHT + (TONGUE_LIGHT - GAP_LIGHT) * smoothstep((v - TEETH_END) / (1 - TEETH_END)) * to_middle
    colours = tongue[..., None] * lips
    colours = colours + tooth_weight * (shade[..., None] * teeth - colours)
    edges = smoothstep(np.minimum(v, 1 - v) / EDGE_FADE) * smoothstep(np.minimum(t, 1 - t) / CORNER_FADE)
    grid = np.stack(np.meshgrid(_COLUMNS, np.linspace(0, 1, _ROWS)), axis=-1).reshape(-1, 2)
    alpha = np.asarray(np.rint(255 * edges), np.uint8)
    return MouthInterior(to_srgb(colours), alpha, grid, grid_triangles(_ROWS, len(_COLUMNS)))


def _saturate(colour: NDArray[np.float64], saturation: float) -> NDArray[np.float64]:
    """Return a colour (3,) whose distance from grey is multiplied."""
    luma = float(colour @ _LUMA)
    return luma + saturation * (colour - luma)


def _mean_colour(
    light: NDArray[np.float64], warp: PortraitWarp, pairs: tuple[tuple[int, int], ...]
) -> NDArray[np.float64]:
    """Return the median colour (3,) of a photo in the middle between pairs of landmarks."""
    rows = [contours.landmark_rows(pair) for pair in pairs]
    points = warp.mesh.positions[rows].mean(axis=1)
    height, width = light.shape[:2]
    x, y = np.rint((points * (1 / warp.shape.aspect, -1) + 0.5) * (width, height) - 0.5).astype(int).T
    x, y = np.clip(x, 2, width - 3), np.clip(y, 2, height - 3)
    around = [light[b - 2 : b + 3, a - 2 : a + 3].reshape(-1, 3) for a, b in zip(x, y, strict=True)]
    return np.asarray(np.median(np.concatenate(around), axis=0))
