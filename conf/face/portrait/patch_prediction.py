"""A patch's picture told by how it differs from the photograph: both sides paint the photograph over, then correct it.

Strategy. Most of what is seen around a mouth or an eye is skin that the photograph shows too. Moved by the control
points to where the patch has them, it foretells the patch; only the difference travels, in the frequencies of small
blocks: what the photograph cannot know, teeth, a tongue, a shut lid, and hardly anything else.
Source: Bookstein 1989 (thin-plate splines); Wallace 1991 (blocks of 8 by 8, two tints of half the size).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn
from scipy.ndimage import map_coordinates, zoom

from conf.face.deformation.kernels import KERNELS
from conf.face.deformation.rbf import build_operator
from conf.face.portrait.patch_features import PatchRegion
from conf.face.portrait.warp import PortraitWarp

BLOCK = 8
CHROMA_STEP = 1.5  # steps of tint for one of brightness
_SMOOTHING = 1e-3
# Brightness and two tints of blue, green and red; and back. Source: ITU-R BT.601.
_TO_PLANES = np.array([[0.114, 0.587, 0.299], [0.5, -0.33126, -0.16874], [-0.08131, -0.41869, 0.5]])
_FROM_PLANES = np.linalg.inv(_TO_PLANES)
# A block's coefficients as they are told: the lowest row + column first, of those the lowest row.
_ZIGZAG = np.array(sorted(range(BLOCK * BLOCK), key=lambda i: (i // BLOCK + i % BLOCK, i // BLOCK)))

Picture = NDArray[np.float64]


def predict_patch(
    photo: NDArray[np.uint8],
    region_points_in_photo: NDArray[np.float64],
    points: NDArray[np.float64],
    size: tuple[int, int],
    /,
) -> Picture:
    """Return (h, w, 3) what the photograph says of a patch.

    photo : (H, W, 3) uint8; photo_points, points : (m, 2) the same control points in photograph and patch, 0 to 1 from
    the upper left corner; size : width and height of the patch in px
    """
    width, height = size
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    places = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    centres = np.column_stack([points * size, np.zeros(len(points))])
    kernel = KERNELS["thin-plate"]
    operator = build_operator(places, centres, kernel=kernel, epsilon=1 / max(size), smoothing=_SMOOTHING)
    at = operator.matrix.astype(np.float64) @ (region_points_in_photo * photo.shape[1::-1]) - 0.5
    channels = np.moveaxis(photo.astype(np.float64), -1, 0)
    seen = [map_coordinates(channel, at.T[::-1], order=1, mode="nearest") for channel in channels]
    return np.stack(seen, axis=-1).reshape(height, width, 3)


def region_points_in_photo(warp: PortraitWarp, feature: PatchRegion, /) -> NDArray[np.float64]:
    """Return where a feature's control points are in the photograph, (m, 2) 0 to 1 from its upper left corner."""
    return np.asarray(warp.mesh.positions[list(feature.points)] / (warp.shape.aspect, -1.0) + 0.5)


def forward_dct(difference: Picture, /) -> list[NDArray[np.float64]]:
    """Return the coefficients (rows, columns, 64) of a difference (h, w, 3) BGR: of brightness, then of two tints."""
    luma, *chroma = np.moveaxis(difference @ _TO_PLANES.T, -1, 0)
    return [_blocks(luma), *(_blocks(_halve(tint)) / CHROMA_STEP for tint in chroma)]


def inverse_dct(planes: Sequence[NDArray[np.floating]], size: tuple[int, int], /) -> Picture:
    """Return the difference (h, w, 3) of coefficients; size : its width and height."""
    width, height = size
    half = (-(-height // 2), -(-width // 2))
    luma = _pixels(planes[0], (height, width))
    chroma = [_double(_pixels(plane * CHROMA_STEP, half))[:height, :width] for plane in planes[1:]]
    return np.asarray(np.stack([luma, *chroma], axis=-1) @ _FROM_PLANES.T)


def _blocks(plane: Picture) -> NDArray[np.float64]:
    rows, columns = (-(-side // BLOCK) for side in plane.shape)
    padded = np.pad(plane, [(0, -side % BLOCK) for side in plane.shape], "edge")
    blocks = padded.reshape(rows, BLOCK, columns, BLOCK).swapaxes(1, 2)
    return np.asarray(dctn(blocks, axes=(2, 3), norm="ortho").reshape(rows, columns, -1)[..., _ZIGZAG])


def _pixels(plane: NDArray[np.floating], shape: tuple[int, int]) -> Picture:
    rows, columns, _ = plane.shape
    blocks = np.zeros(plane.shape)
    blocks[..., _ZIGZAG] = plane
    pixels = idctn(blocks.reshape(rows, columns, BLOCK, BLOCK), axes=(2, 3), norm="ortho")
    return np.asarray(pixels.swapaxes(1, 2).reshape(rows * BLOCK, columns * BLOCK)[: shape[0], : shape[1]])


def _halve(plane: Picture) -> Picture:
    even = np.pad(plane, [(0, side % 2) for side in plane.shape], "edge")
    return np.asarray(even.reshape(even.shape[0] // 2, 2, even.shape[1] // 2, 2).mean(axis=(1, 3)))


def _double(plane: Picture) -> Picture:
    return np.asarray(zoom(plane, 2, order=1, mode="nearest", grid_mode=True))
