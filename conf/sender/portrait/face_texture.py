"""Predict how well images of a head show it in other frames: compare them on the mesh of the photo.

Strategy: every image is sampled where the mesh of its photo is in it, so the same texel shows the same skin. With local
mean and contrast removed, the structural similarity of two textures, or of blends of them, follows from the scalar
products of all pairs, so trying a view in all recent frames costs little.
Source: Wang, Bovik, Sheikh, Simoncelli 2004 (SSIM), on textures instead of windows.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.head_views import view_alpha
from conf.face.portrait.warp import PortraitWarp
from conf.sender.portrait.photo_averaging import barycentric_weights

TEXTURE_SIZE = 96  # px, width and height: about the resolution of a face in a photo
WINDOW_SIGMA = 1.5  # px, of SSIM's window
NOISE = 0.03 * 255 / np.sqrt(2)  # grey levels of local contrast: SSIM's constant, which stands beside two variances

Textures = NDArray[np.float32]


class FaceTexture:
    """Samples images of one person at the texels of the photo's face."""

    def __init__(self, warp: PortraitWarp, /) -> None:
        alpha = view_alpha(warp)
        shown = warp.mesh.positions[alpha > 0]
        low, high = shown.min(axis=0), shown.max(axis=0)
        scaled = (warp.mesh.positions - (low + high) / 2) / (high - low).max()  # the face is 1 wide or high
        self._weights, inside = barycentric_weights(scaled, warp.mesh.triangles, (TEXTURE_SIZE, TEXTURE_SIZE))
        opacity = np.maximum(0.0, (self._weights @ alpha).reshape(inside.shape))  # corners extrapolate
        self._mask = np.sqrt(opacity / max(float(opacity.sum()), 1e-6)).astype(np.float32)

    def describe(self, pixels: NDArray[np.uint8], positions: NDArray[np.float64], /) -> Textures:
        """Return (k,) the texture of an image (h, w, 3) uint8 BGR, normalised; the norm of sharp skin is about 1.

        positions : (V, 2) of the mesh in the image, image heights from its centre
        """
        height, width = pixels.shape[:2]
        scale = (height, -height)
        return self.describe_at(pixels, positions * scale + (width / 2, height / 2) - 0.5)

    def describe_at(self, pixels: NDArray[np.uint8], positions: NDArray[np.float64], /) -> Textures:
        """Return (k,) as describe. positions : (V, 2) px, x right, y down, 0 in the middle of the first pixel"""
        grey = cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY)
        x, y = (self._weights @ positions).astype(np.float32).T.reshape(2, TEXTURE_SIZE, TEXTURE_SIZE)
        texels = cv2.remap(grey, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE).astype(np.float32)
        mean = _blur(texels)
        variance = np.maximum(_blur(texels * texels) - mean * mean, 0)
        return np.asarray(((texels - mean) / np.sqrt(variance + NOISE**2) * self._mask).ravel(), np.float32)


def similarities(products: NDArray[np.float64], weights: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return (N,), at most 1: about the structural similarity of N frames and blends of M images.

    products : (N + M, N + M) scalar products of the textures of frames, then images; weights : (N, M) of the images
    """
    count = len(weights)
    cross = np.sum(weights * products[:count, count:], axis=1)
    blended = np.einsum("ij,jk,ik->i", weights, products[count:, count:], weights)
    own = np.diagonal(products)[:count]
    return np.asarray(1 - own * (1 - 2 * cross / np.maximum(own + blended, 1e-9)), np.float64)


def _blur(texels: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(cv2.GaussianBlur(texels, (0, 0), WINDOW_SIGMA), np.float32)
