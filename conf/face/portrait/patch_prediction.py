"""Predict a patch from the photo and code the residual with a DCT.

Most of the area around a mouth or an eye is skin that the photo also shows. Warped by the control points to the patch's
geometry, the photo predicts the patch. Only the residual is sent, as the DCT coefficients of small blocks: mostly what
the photo cannot show, such as teeth, tongue or a closed lid.
Source: Bookstein 1989 (thin-plate splines); Wallace 1991 (JPEG: 8 x 8 blocks, chroma at half resolution).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn
from scipy.ndimage import map_coordinates, zoom

from conf.face.portrait.lid_sliding import LidSliding
from conf.face.portrait.patch_features import EYES, PatchRegion
from conf.face.portrait.warp import PortraitWarp, thin_plate_matrix

BLOCK = 8
CHROMA_STEP = 1.5  # quantisation step of chroma, of that of luma
_SMOOTHING = 1e-3
# From BGR to luma and two chroma planes. Source: ITU-R BT.601.
_FROM_BGR = np.array([[0.114, 0.587, 0.299], [0.5, -0.33126, -0.16874], [-0.08131, -0.41869, 0.5]])
_TO_BGR = np.linalg.inv(_FROM_BGR)
# Order of a block's coefficients: by row + column, then by row.
_ZIGZAG = np.array(sorted(range(BLOCK * BLOCK), key=lambda i: (i // BLOCK + i % BLOCK, i // BLOCK)))

Image = NDArray[np.float64]


def predict_patch(
    photo: NDArray[np.uint8],
    photo_points: NDArray[np.float64],
    points: NDArray[np.float64],
    size: tuple[int, int],
    /,
    lids: LidSliding | None = None,
) -> Image:
    """Return the prediction (h, w, 3) of a patch from the photo.

    photo : (H, W, 3) uint8
    photo_points, points : (m, 2) the same control points in photo and patch, 0 to 1 from the upper left corner
    size : width and height of the patch in px
    lids : for a patch of the eyes
    """
    width, height = size
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    pixels = np.column_stack([x.ravel(), y.ravel()])
    matrix = thin_plate_matrix(pixels, points * size, epsilon=1 / max(size), smoothing=_SMOOTHING)
    sources = matrix.astype(np.float64) @ photo_points
    if lids is not None:
        sources = lids.slide(sources, pixels, points, size)
    sources = sources * photo.shape[1::-1] - 0.5
    channels = np.moveaxis(photo.astype(np.float64), -1, 0)
    samples = [map_coordinates(channel, sources.T[::-1], order=1, mode="nearest") for channel in channels]
    return np.stack(samples, axis=-1).reshape(height, width, 3)


class PatchPredictor:
    """Predicts patches from one photo."""

    def __init__(self, photo: NDArray[np.uint8], warp: PortraitWarp, /) -> None:
        """photo : (H, W, 3) uint8"""
        self._photo = photo
        self._warp = warp
        self._lids = LidSliding(warp)

    def predict(self, region: PatchRegion, points: NDArray[np.float64], size: tuple[int, int], /) -> Image:
        """Return the prediction (h, w, 3) of a patch with control points (m, 2), 0 to 1; size : its width and height.

        Raises ValueError if the points coincide.
        """
        known = region_points_in_photo(self._warp, region)
        return predict_patch(self._photo, known, points, size, lids=self._lids if region is EYES else None)


def region_points_in_photo(warp: PortraitWarp, region: PatchRegion, /) -> NDArray[np.float64]:
    """Return the region's control points in the photo, (m, 2) 0 to 1 from its upper left corner."""
    return np.asarray(warp.mesh.positions[list(region.points)] / (warp.shape.aspect, -1.0) + 0.5)


def forward_dct(residual: Image, /) -> list[NDArray[np.float64]]:
    """Return the coefficients (rows, columns, 64) of a residual (h, w, 3) BGR: of luma, then of the chroma planes."""
    luma, *chroma = np.moveaxis(residual @ _FROM_BGR.T, -1, 0)
    return [_to_blocks(luma), *(_to_blocks(_halve(plane)) / CHROMA_STEP for plane in chroma)]


def inverse_dct(planes: Sequence[NDArray[np.floating]], size: tuple[int, int], /) -> Image:
    """Return the residual (h, w, 3) BGR of coefficients; size : its width and height."""
    width, height = size
    half = (-(-height // 2), -(-width // 2))
    luma = _from_blocks(planes[0], (height, width))
    chroma = [_double(_from_blocks(plane * CHROMA_STEP, half))[:height, :width] for plane in planes[1:]]
    return np.asarray(np.stack([luma, *chroma], axis=-1) @ _TO_BGR.T)


def _to_blocks(plane: Image) -> NDArray[np.float64]:
    rows, columns = (-(-side // BLOCK) for side in plane.shape)
    padded = np.pad(plane, [(0, -side % BLOCK) for side in plane.shape], "edge")
    blocks = padded.reshape(rows, BLOCK, columns, BLOCK).swapaxes(1, 2)
    return np.asarray(dctn(blocks, axes=(2, 3), norm="ortho").reshape(rows, columns, -1)[..., _ZIGZAG])


def _from_blocks(plane: NDArray[np.floating], shape: tuple[int, int]) -> Image:
    rows, columns, _ = plane.shape
    blocks = np.zeros(plane.shape)
    blocks[..., _ZIGZAG] = plane
    pixels = idctn(blocks.reshape(rows, columns, BLOCK, BLOCK), axes=(2, 3), norm="ortho")
    return np.asarray(pixels.swapaxes(1, 2).reshape(rows * BLOCK, columns * BLOCK)[: shape[0], : shape[1]])


def _halve(plane: Image) -> Image:
    even = np.pad(plane, [(0, side % 2) for side in plane.shape], "edge")
    return np.asarray(even.reshape(even.shape[0] // 2, 2, even.shape[1] // 2, 2).mean(axis=(1, 3)))


def _double(plane: Image) -> Image:
    return np.asarray(zoom(plane, 2, order=1, mode="nearest", grid_mode=True))
