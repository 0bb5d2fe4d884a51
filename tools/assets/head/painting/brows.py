"""Draw the eyebrows hair by hair on a plane in front of the face and project them onto the skin."""

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from tools.assets.head.painting.texels import Texels

_SCALE = 160  # px/cm
_WIDTH, _HEIGHT = 7.0, 3.2  # of the plane, cm; it starts at x = 0 and is centred on the brow
_HAIRS = 640
# Offsets from the control points inner, top and outer to start, peak and end of the brow's centre line, cm.
_SPINE = np.array([(-0.1, -0.42), (-0.1, -0.2), (-0.4, 0.3)])
_OVERSAMPLE = 16  # cv2's fractional bits are 4


def brow_coverage(texels: Texels, points: Mapping[str, NDArray[np.float64]], thickness: float) -> NDArray[np.float64]:
    """Return the (N,) coverage of each texel by brow hair, 0 to 1; both sides have the same shape but other hairs.

    thickness : relative to the default head's
    """
    inner, top, outer = (points[f"brow_{name}_l"] for name in ("inner", "top", "outer"))
    bottom = top[1] - _HEIGHT / 2
    coverage = np.zeros(len(texels.row))
    x, y, z = texels.position.T
    front = (z > -1.5) & (texels.normal[:, 2] > 0.05)
    for sign in (1, -1):
        plane = _draw((inner, top, outer), thickness, bottom, np.random.default_rng(40 + sign))
        drawn = map_coordinates(plane, [(y - bottom) * _SCALE, x * sign * _SCALE], order=1)
        coverage = np.maximum(coverage, np.where(front & (x * sign > 0), drawn, 0))
    return coverage


def _draw(
    spine: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    thickness: float,
    bottom: float,
    random: np.random.Generator,
) -> NDArray[np.float32]:
    plane = np.zeros((int(_HEIGHT * _SCALE), int(_WIDTH * _SCALE)), dtype=np.uint8)
    along = random.uniform(0, 0.97, _HAIRS) ** 0.9
    across = np.clip(random.normal(0, 0.45, _HAIRS), -1, 1)
    for s, d in zip(along, across, strict=True):
        x, y, slope = _spine(s, *spine)
        thick = 0.34 * thickness * np.interp(s, [0, 0.12, 0.6, 1], [0.7, 1.0, 0.75, 0.25])
        lean = np.interp(s, [0, 0.25, 1], [1.15, 0.55, 0.12]) - 0.35 * d + random.normal(0, 0.12)
        angle = slope + lean
        length = random.uniform(0.42, 0.62) * np.interp(s, [0, 0.3, 1], [0.8, 1.0, 0.75])
        start = np.array([x - 0.12, y - bottom + d * thick])
        middle = start + length * 0.55 * np.array([np.cos(angle), np.sin(angle)])
        end = middle + length * 0.45 * np.array([np.cos(angle - 0.25), np.sin(angle - 0.25)])
        path = (np.array([start, middle, end]) * _SCALE * _OVERSAMPLE).astype(np.int32)
        hair = np.zeros_like(plane)
        strength = int(random.uniform(110, 205) * np.interp(s, [0, 0.15, 0.7, 1], [0.65, 1.0, 1.0, 0.6]))
        cv2.polylines(hair, [path], False, strength, 3, cv2.LINE_AA, 4)
        plane = np.maximum(plane, hair)
    soft = cv2.GaussianBlur(plane, (0, 0), 0.22 * _SCALE * 0.5)
    return np.clip(plane.astype(np.float32) / 255 * 0.85 + soft.astype(np.float32) / 255 * 0.45, 0, 0.95)


def _spine(
    s: float, inner: NDArray[np.float64], top: NDArray[np.float64], outer: NDArray[np.float64]
) -> tuple[float, float, float]:
    """Return x, y and slope (radians) of the brow's centre line at s from 0 (inner end) to 1 (outer end)."""
    start, peak, end = (point[:2] + shift for point, shift in zip((inner, top, outer), _SPINE, strict=True))
    control = 2 * peak - (start + end) / 2
    x, y = (1 - s) ** 2 * start + 2 * s * (1 - s) * control + s**2 * end
    dx, dy = 2 * (1 - s) * (control - start) + 2 * s * (end - control)
    return float(x), float(y), float(np.arctan2(dy, dx))
