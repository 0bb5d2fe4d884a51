"""Average a photo over recent frames: each is aligned with it by the photo's mesh, then by a smooth optical flow.

Strategy: the receiver deforms the photo with fifty points, and rendered skin is some pixels off. The mean of frames
that were deformed back by the same mesh shows what they have in common, which is nearest to all of them. Where a frame
differs from the photo, as in a mouth that opens or behind a hand, it has little weight: the photo stays sharp there.
The landmarks of a single frame are off the skin, too: the average is moved under the mesh to where the skin is in the
mean of all frames.
Source: Kroeger et al. 2016 (DIS optical flow).
"""

from collections.abc import Iterator, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from conf.face.portrait.warp import PortraitWarp
from conf.sender.portrait.recent_frames import RecentFrame

FRAMES_PER_STEP = 2  # 6 ms each
FLOW_SIGMA = 8 / 240  # image heights: the flow is as smooth as the skin moves
FLOW_SCALE = 4  # the flow is smoothed at a fraction of the resolution
DIFFERENCE_SIGMA = 2 / 240  # image heights: noise is no difference
CENTRE_SIGMA = 4 / 240  # image heights: the mean offset is smoothed, as the weights vary
MAX_DIFFERENCE = 25.0  # of 255, at which a frame has 1/e of its weight

Image = NDArray[np.float32]


def average_steps(
    photo: NDArray[np.uint8], warp: PortraitWarp, positions: NDArray[np.float64], frames: Sequence[RecentFrame], /
) -> Iterator[NDArray[np.uint8] | None]:
    """Average an image (h, w, 3) uint8 BGR and frames of the same size, FRAMES_PER_STEP in a step.

    positions : (V, 2) of the warp's mesh in the image
    Yields None after each step, and the average after the last.
    """
    aligner = MeshAligner(warp, positions, (photo.shape[1], photo.shape[0]))
    total, weights = photo.astype(np.float32), np.ones(photo.shape[:2], np.float32)
    offsets = np.zeros((*photo.shape[:2], 2), np.float32)
    yield None
    for number, frame in enumerate(frames):
        if frame.pixels.shape == photo.shape:
            aligned, weight, offset = aligner.align(photo, frame)
            total += weight[..., None] * aligned
            weights += weight
            offsets += weight[..., None] * offset
        if number % FRAMES_PER_STEP:
            yield None
    average = total / weights[..., None]
    offset = _smooth(np.asarray(offsets / weights[..., None], np.float32), CENTRE_SIGMA * len(photo))
    centred = _remap(average, aligner.grid - offset, interpolation=cv2.INTER_CUBIC)
    yield np.asarray(np.clip(np.rint(centred), 0, 255), np.uint8)


class MeshAligner:
    """Deforms frames to the image in which the mesh of a warp has the given positions."""

    def __init__(self, warp: PortraitWarp, positions: NDArray[np.float64], size: tuple[int, int], /) -> None:
        """positions : (V, 2) of the mesh in the image; size : width and height of the image, px"""
        width, height = size
        self._warp = warp
        self._size = size
        self._weights, inside = barycentric_weights(positions, warp.mesh.triangles, size)
        self._inside = cv2.GaussianBlur(inside.astype(np.float32), (0, 0), 1.5)
        x, y = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
        self.grid = np.dstack([x, y])
        self._outside = ~inside
        self._flow = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST)

    def interpolate(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (h, w): values (V,) at the mesh's vertices, interpolated over the image; 0 outside the mesh."""
        width, height = self._size
        return np.asarray(self._weights @ values, np.float64).reshape(height, width)

    def align(self, image: NDArray[np.uint8], frame: RecentFrame) -> tuple[Image, Image, Image]:
        """Return the frame deformed to the image (h, w, 3), and at each pixel its weight and its offset.

        The weight, (h, w), is 0 to 1. The offset, (h, w, 2) px, is that of the skin in the frame from where the mesh
        has the skin of the image.
        """
        width, height = self._size
        positions = self._warp.deform(frame.motion.displacements, frame.pose)
        pixels = positions * (height, -height) + (width / 2, height / 2) - 0.5
        sources: Image = (self._weights @ pixels).astype(np.float32).reshape(height, width, 2)
        sources[self._outside] = self.grid[self._outside]
        flow = self._flow.calc(_grey(image), _grey(_remap(frame.pixels, sources)), np.zeros_like(sources))
        smooth = _smooth(np.asarray(flow, np.float32), FLOW_SIGMA * height)
        aligned = _remap(frame.pixels, _remap(sources, np.asarray(self.grid + smooth, np.float32)))
        squares = np.square(aligned.astype(np.float32) - image).mean(axis=2)
        difference = cv2.GaussianBlur(squares, (0, 0), DIFFERENCE_SIGMA * height)
        weight = np.exp(-difference / MAX_DIFFERENCE**2) * self._inside
        return np.asarray(aligned, np.float32), np.asarray(weight, np.float32), smooth


def barycentric_weights(
    positions: NDArray[np.float64], triangles: NDArray[np.int32], size: tuple[int, int], /
) -> tuple[sparse.csr_array, NDArray[np.bool_]]:
    """Return the (h w, V) matrix from vertices to pixels, and (h, w) whether a triangle covers each pixel.

    positions : (V, 2) image heights from the centre, y up; size : width and height, px
    """
    width, height = size
    corners = positions * (height, -height) + (width / 2, height / 2) - 0.5
    index = np.full((height, width), -1, np.int32)
    for number, triangle in enumerate(np.rint(corners[triangles] * 16).astype(np.int32)):
        cv2.fillConvexPoly(index, triangle, number, lineType=cv2.LINE_8, shift=4)
    rows = np.flatnonzero(index.ravel() >= 0)
    chosen = triangles[index.ravel()[rows]]
    a, b, c = (corners[chosen[:, i]] for i in range(3))
    pixels = np.column_stack([rows % width, rows // width]).astype(np.float64)
    area = _cross(b - a, c - a)
    area = np.where(np.abs(area) < 1e-9, 1e-9, area)
    beta, gamma = _cross(pixels - a, c - a) / area, _cross(b - a, pixels - a) / area
    weights = np.column_stack([1 - beta - gamma, beta, gamma])
    entries = (weights.ravel(), (np.repeat(rows, 3), chosen.ravel()))
    return sparse.csr_array(entries, shape=(width * height, len(positions))), index >= 0


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _smooth(flow: Image, sigma: float) -> Image:
    """Return a flow (h, w, 2) blurred with a standard deviation of `sigma` px."""
    height, width = flow.shape[:2]
    small = cv2.resize(flow, (-(-width // FLOW_SCALE), -(-height // FLOW_SCALE)), interpolation=cv2.INTER_AREA)
    small = cv2.GaussianBlur(small, (0, 0), sigma / FLOW_SCALE)
    return np.asarray(cv2.resize(small, (width, height), interpolation=cv2.INTER_LINEAR), np.float32)


def _grey(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY), np.uint8)


def _remap(values: NDArray[Any], sources: Image, *, interpolation: int = cv2.INTER_LINEAR) -> NDArray[Any]:
    """Return an image's values at other positions (h, w, 2), px."""
    x, y = np.ascontiguousarray(np.moveaxis(sources, 2, 0))
    return np.asarray(cv2.remap(values, x, y, interpolation, borderMode=cv2.BORDER_REPLICATE))
