"""Predict the skin and the lashes of lids that are closer together than in the photo.

A photo of open eyes shows hardly any of the upper lid, and half of its lashes lie in front of the eyeball. Moved by the
mesh alone, a closing lid is a stretched crease with a torn lash line. Its skin is therefore predicted from the skin
above and below the eye, and its lash line from the dark edge of the upper lid. The shape of that line was measured on
the closed eyes of three filmed people, in whom it differed by less than 0.03 of the eye's length.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, map_coordinates

from conf.face.interpolation import smoothstep
from conf.face.portrait.eyelid_closure import EyeOpening
from conf.face.portrait.lip_lid_gaps import Opening, height_at
from conf.face.portrait.warp import PortraitWarp
from conf.receiver.portrait.textured_grid import Image, grid_triangles, to_linear, to_srgb

# Heights and widths are of the eye's length, heights upwards from the edge of the upper lid.
LASH_HEIGHT = -0.04  # of the darkest part of a closed eye
LASH_SIGMA = (0.085, 0.055)  # standard deviations of the lash line below and above its darkest part
LASH_GAIN = 1.3  # of the Gaussian's peak, clipped at 1: the middle of the line is evenly dark
LASH_TAPER = 0.5  # lower opacity at the inner corner, where lashes are short
LASH_QUANTILE = 0.35  # of the darkest colours along the edge: neither a pupil's nor a light gap's
EDGE_RISE = 0.08  # of the edge of closed lids: filmed lids meet higher than those of the mesh
EDGE_DEGREE = 3  # of the polynomial that smooths the edge
LASH_TOP, LASH_BOTTOM = 0.1, -0.3
LID_START = 0.06  # height over which the lid's skin sets in behind the lash line
LID_FADE = 0.24  # height above the closed part over which it fades
SKIN_ABOVE = (0.2, 0.34)  # heights in the photo between which the skin above the upper lid is sampled
SKIN_BELOW = (-0.5, -0.36)  # the same below the edge of the lower lid
LASHES_IN_PHOTO = (-0.08, 0.06)
BELOW_WEIGHT = 0.4  # of the skin below in the lid's lowest part: it is turned to the light as the cheek is
CLOSURE = (0.2, 0.85)  # of the photo's gap: prediction begins at the first closure and is opaque from the second on
MIN_GAP = 0.16  # eyes less open in the photo already show their lids
LASH_DEPTH = ((0.5, 0.9), (0.5, 1.0))  # closures and depths of the lash line: half-shut, the lower lashes are apart
CORNER = 0.06  # width by which lids extend beyond the corners of the eye
CORNER_FADE = 0.2
NOMINAL_CLOSED = 0.3  # closed part that the texture is made for; the grid stretches it
SIZE = (32, 64)  # width and height of the texture, px
_COLUMNS = np.linspace(-CORNER, 1 + CORNER, 17)  # of the grid, along the eye
_WITHIN = (_COLUMNS >= 0) & (_COLUMNS <= 1)
# (columns, columns within the eye): least squares fit of a polynomial to the heights of an edge
_SMOOTHING = np.vander(_COLUMNS, EDGE_DEGREE + 1) @ np.linalg.pinv(np.vander(_COLUMNS[_WITHIN], EDGE_DEGREE + 1))
_LASH_ROWS = np.linspace(LASH_BOTTOM, LASH_TOP, 5)  # heights
_LID_ROWS = np.linspace(0, 1, 5)[1:]  # of the height from LASH_TOP to where the lid has faded
_ROW_UVS = np.linspace(0, 1, len(_LASH_ROWS) + len(_LID_ROWS))


@dataclass(frozen=True)
class ShutLid:
    """The predicted lid of one eye: a textured grid of k vertices.

    eye : the eye's vertices in the photo's mesh
    photo_gaps : (columns,) between the lids in the photo, of the eye's length
    colours : (h, w, 3) uint8 BGR; alpha : (h, w) uint8
    uvs : (k, 2) texture coordinates; triangles : (F, 3)
    """

    eye: EyeOpening
    photo_gaps: NDArray[np.float64]
    colours: NDArray[np.uint8]
    alpha: NDArray[np.uint8]
    uvs: NDArray[np.float64]
    triangles: NDArray[np.int32]

    def grid(self, positions: NDArray[np.float64], /) -> tuple[NDArray[np.float64], float]:
        """Return the grid's vertices (k, 2) over an eye of the deformed mesh (V, 2), and their opacity.

        With opacity 0 there are no vertices.
        """
        opening = Opening.between(positions[self.eye.upper], positions[self.eye.lower])
        x = _COLUMNS * opening.length
        gaps = (height_at(opening.upper, x) - height_at(opening.lower, x)) / opening.length
        closed = np.maximum(self.photo_gaps - gaps, 0.0)
        middle = len(_COLUMNS) // 2
        closure = float(closed[middle]) / max(float(self.photo_gaps[middle]), MIN_GAP)
        opacity = float(smoothstep((closure - CLOSURE[0]) / (CLOSURE[1] - CLOSURE[0])))
        if opacity == 0:
            return np.zeros((0, 2)), 0.0
        edge = _SMOOTHING @ height_at(opening.upper, x[_WITHIN]) / opening.length + EDGE_RISE * closure
        lid = LASH_TOP + _LID_ROWS[:, None] * (closed + LID_FADE - LASH_TOP)
        lashes = _LASH_ROWS * np.where(_LASH_ROWS < 0, np.interp(closure, *LASH_DEPTH), 1.0)
        heights = edge + np.concatenate([np.broadcast_to(lashes[:, None], (len(lashes), len(x))), lid])
        along, up = opening.length * opening.along, opening.length * opening.up
        return (opening.origin + _COLUMNS[:, None] * along + heights[..., None] * up).reshape(-1, 2), opacity


def predict_shut_lids(photo: NDArray[np.uint8], warp: PortraitWarp, /) -> tuple[ShutLid, ...]:
    """Return the lids of both eyes. photo : (H, W, 3) uint8 BGR"""
    light = to_linear(photo)
    grid = np.stack(np.meshgrid(np.linspace(0, 1, len(_COLUMNS)), _ROW_UVS), axis=-1).reshape(-1, 2)
    lids = []
    for eye in warp.mesh.eyes:
        x = _COLUMNS * eye.photo.length
        gaps = (height_at(eye.photo.upper, x) - height_at(eye.photo.lower, x)) / eye.photo.length
        lids.append(
            ShutLid(
                eye,
                gaps,
                *_paint(light, eye.photo, warp.shape.aspect),
                grid,
                grid_triangles(len(_ROW_UVS), len(_COLUMNS)),
            )
        )
    return tuple(lids)


def _paint(light: Image, eye: Opening, aspect: float) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return the colours (h, w, 3) BGR and the alpha (h, w) of a closed eye. light : (H, W, 3) the photo, linear"""
    width, height = SIZE
    t = np.linspace(_COLUMNS[0], _COLUMNS[-1], width)
    above = _smooth(np.median(_sample(light, eye, eye.upper, t, SKIN_ABOVE, aspect), axis=0))
    below = _smooth(np.median(_sample(light, eye, eye.lower, t, SKIN_BELOW, aspect), axis=0))
    edge = _sample(light, eye, eye.upper, t, LASHES_IN_PHOTO, aspect)
    darkest = edge[np.argmin(edge.sum(axis=2), axis=0), np.arange(width)]
    lash_colour = np.quantile(darkest, LASH_QUANTILE, axis=0)
    top = NOMINAL_CLOSED + LID_FADE
    rows = np.concatenate([_LASH_ROWS, LASH_TOP + _LID_ROWS * (top - LASH_TOP)])
    heights = np.interp(np.linspace(0, 1, height), _ROW_UVS, rows)[:, None]
    weight = BELOW_WEIGHT * np.clip(1 - heights / top, 0, 1)[..., None]
    skin = above + weight * (below - above)
    corners = smoothstep((CORNER + np.minimum(t, 1 - t)) / CORNER_FADE)  # (w,)
    lash = _lash_alpha(heights, corners) * (1 - LASH_TAPER * smoothstep((t - 0.5) / 0.5))
    lid = smoothstep((top - heights) / LID_FADE) * smoothstep((heights - LASH_HEIGHT) / LID_START)
    # Lashes in front of skin: the alpha of both, and the colour that yields the same over any background.
    alpha = 1 - (1 - lash) * (1 - lid)
    mixed = lash[..., None] * lash_colour + ((1 - lash) * lid)[..., None] * skin
    colours = to_srgb(mixed / np.maximum(alpha, 1e-6)[..., None])
    return colours, np.asarray(np.rint(255 * alpha * corners), np.uint8)


def _lash_alpha(heights: NDArray[np.float64], thickness: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (h, w) the opacity of the lash line at heights (h, 1). thickness : (w,) 0 to 1"""
    sigma = np.where(heights < LASH_HEIGHT, *LASH_SIGMA) * np.maximum(thickness, 0.1)
    return np.asarray(np.minimum(LASH_GAIN * np.exp(-0.5 * ((heights - LASH_HEIGHT) / sigma) ** 2), 1))


def _sample(
    light: Image,
    eye: Opening,
    edge: NDArray[np.float64],
    t: NDArray[np.float64],
    between: tuple[float, float],
    aspect: float,
) -> Image:
    """Return (k, w, 3) the photo's colours between two heights from an edge (n, 2) of an eye, at t (w,) along it."""
    x = np.clip(t, 0, 1) * eye.length
    heights = height_at(edge, x) + np.linspace(*between, 7)[:, None] * eye.length
    points = eye.origin + x[:, None] * eye.along + heights[..., None] * eye.up
    pixels = (points * (1 / aspect, -1) + 0.5) * light.shape[1::-1] - 0.5
    coordinates = [pixels[..., 1], pixels[..., 0]]
    return np.stack([map_coordinates(light[..., i], coordinates, order=1, mode="nearest") for i in range(3)], axis=-1)


def _smooth(colours: Image) -> Image:
    """Return colours (w, 3) along the eye without single hairs."""
    return np.asarray(gaussian_filter1d(colours, len(colours) / 10, axis=0, mode="nearest"))
