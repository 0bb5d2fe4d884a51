"""Segment the person in an image: by chroma key before a plain blue or green wall, else by GrabCut from the landmarks.

Source: Rother, Kolmogorov, Blake 2004 (GrabCut); the thesis used a plain blue background.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.portrait import contours

MAX_CORNERS = 64
WORK_HEIGHT = 120  # px: the image is segmented at this height
MIN_WALL_FRACTION = 0.75  # of the border that must have the wall's hue
MIN_HUE, MAX_HUE = 35, 130  # OpenCV's, 0 to 180: from green to blue
MIN_SATURATION = 20
HUE_TOLERANCE = 12  # a plain wall varies in brightness, but not in hue
MAX_KEY_DISTANCE = 22.0  # from the wall's colour, in the a-b plane of Lab
MIN_WALL_LIGHTNESS = 0.6  # of the wall's darker parts, L of Lab: darker pixels of its hue are clothes
WALL_SHADE = 0.1  # quantile of the border's lightness

MIN_AREA_PX = 20  # of person and of background: fewer pixels give no colour model
PADDING = 8  # px, with which the mask is cleaned: at a bare border it would grow
ITERATIONS = 8  # of GrabCut, one per step

Mask = NDArray[np.uint8]
Corners = list[tuple[float, float]]


def segment_steps(
    pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], /
) -> Iterator[NDArray[np.float64] | None]:
    """Find the person's outline in steps shorter than a frame's interval.

    pixels : (H, W, 3) uint8 BGR; landmarks : (478, 3) px
    Yields None after each step and the outline after the last: (K, 2) 0 to 1 from the upper left corner, K at most
    MAX_CORNERS.
    """
    scale = WORK_HEIGHT / len(pixels)
    small = np.asarray(cv2.resize(pixels, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8)
    prior = BodyPrior.from_oval(landmarks[list(contours.OVAL), :2] * scale)
    mask = _chroma_key(small, prior)
    if mask is not None:
        mask &= prior.draw(small.shape, CHROMA_KEY_AREA)
    else:
        labels = _initial_labels(small, prior)
        chin = int(np.clip(prior.origins["body"][1], 0, len(small)))
        # The head is segmented once more alone: hair can have the colour of a dark room.
        whole, head = _GrabCut(small, labels), _GrabCut(small[:chin], labels[:chin])
        for _ in range(ITERATIONS - 1):
            whole.iterate()
            head.iterate()
            yield None
        mask = whole.iterate()
        mask[:chin] |= head.iterate()
    mask[prior.draw(small.shape, SURE_FOREGROUND) > 0] = 1
    yield _trace_outline(_clean(mask, prior.oval))


SUPERELLIPSE = 0.75  # exponent of the upper half: skulls are fuller than an ellipse


def _ellipse(half_width: float, half_height: float, rise: float) -> Corners:
    """Return a head's outline about the face's middle, moved up by `rise`, in face widths and heights."""
    angles = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    x, y = np.cos(angles), np.sin(angles)
    exponent = np.where(y < 0, SUPERELLIPSE, 1.0)
    x, y = np.sign(x) * np.abs(x) ** exponent, np.sign(y) * np.abs(y) ** exponent
    return [(half_width * float(a), -rise + half_height * float(b)) for a, b in zip(x, y, strict=True)]


# Corners in face widths and heights: of the head from the face's middle, y towards the chin; of the body from the chin.
SURE_FOREGROUND = {
    "head": _ellipse(0.46, 0.66, 0.12),
    "body": [(-0.25, -0.1), (0.25, -0.1), (0.27, 0.28), (0.45, 0.36), (0.8, 0.48), (1.0, 0.75), (1.05, 4.0),
             (-1.05, 4.0), (-1.0, 0.75), (-0.8, 0.48), (-0.45, 0.36), (-0.27, 0.28)],
}  # fmt: skip
PROBABLE_FOREGROUND = {
    "head": _ellipse(0.5, 0.7, 0.14),
    "body": [(-1.1, 0.5), (-0.6, 0.36), (-0.3, 0.22), (-0.28, 0.0), (0.28, 0.0), (0.3, 0.22), (0.6, 0.36), (1.1, 0.5),
             (1.4, 4.0), (-1.4, 4.0)],
}  # fmt: skip
PROBABLE_BACKGROUND = {
    "head": _ellipse(0.82, 0.97, 0.15),
    # Long hair falls beside the neck to the shoulders.
    "body": [(-2.2, 0.3), (-1.0, 0.0), (-0.85, -0.5), (0.85, -0.5), (1.0, 0.0), (2.2, 0.3), (3.2, 1.5), (3.2, 4.0),
             (-3.2, 4.0), (-3.2, 1.5)],
}  # fmt: skip
# Before a plain wall colour separates the person from the rest; only what lies outside this area is excluded.
CHROMA_KEY_AREA = {
    "head": _ellipse(1.7, 1.4, 0.15),
    "body": [(-1.7, -0.2), (1.7, -0.2), (3.2, 1.0), (3.2, 4.0), (-3.2, 4.0), (-3.2, 1.0)],
}


@dataclass(frozen=True)
class BodyPrior:
    """The expected position of head and body, from the face.

    oval : (36, 2) int32 px
    axes : of head and body, (2, 2) from face widths and heights to px; origins : of head and body, (2,) px
    """

    oval: NDArray[np.int32]
    axes: dict[str, NDArray[np.float64]]
    origins: dict[str, NDArray[np.float64]]

    @classmethod
    def from_oval(cls, oval: NDArray[np.floating]) -> Self:
        """Return the prior of a face's oval (36, 2) px: the head tilts with the face, the body stays upright."""
        chin, top = oval[contours.OVAL.index(152)], oval[0]
        height = max(float(np.linalg.norm(chin - top)), 1.0)
        down = (chin - top) / height
        across = np.array([down[1], -down[0]])
        width = float(np.ptp(oval @ across))
        axes = {"head": np.stack([across * width, down * height]), "body": np.diag([width, height])}
        return cls(np.rint(oval).astype(np.int32), axes, {"head": (chin + top) / 2, "body": chin})

    def draw(self, shape: tuple[int, ...], parts: dict[str, Corners]) -> Mask:
        """Return (H, W) uint8, 1 inside the face's oval and the outlines of head and body."""
        mask = np.zeros(shape[:2], np.uint8)
        for part, corners in parts.items():
            polygon = np.array(corners) @ self.axes[part] + self.origins[part]
            cv2.fillPoly(mask, [np.rint(polygon).astype(np.int32)], 1)
        cv2.fillPoly(mask, [self.oval], 1)
        return mask


def _chroma_key(image: NDArray[np.uint8], prior: BodyPrior) -> Mask | None:
    """Return the pixels that have not the wall's colour, or None if there is no plain blue or green wall."""
    height, width = image.shape[:2]
    border = np.zeros((height, width), bool)
    border[: height // 10] = True
    border[: height // 2, : width // 12] = border[: height // 2, -width // 12 :] = True
    hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
    hue, saturation = hsv[..., 0][border], hsv[..., 1][border]
    wall_hue = float(np.median(hue))
    is_wall = (np.abs(hue - wall_hue) <= HUE_TOLERANCE) & (saturation >= MIN_SATURATION)
    if not MIN_HUE <= wall_hue <= MAX_HUE or np.mean(is_wall) < MIN_WALL_FRACTION:
        return None
    lab = cv2.cvtColor(image, cv2.COLOR_BGR2LAB).astype(np.float32)
    chroma = lab[..., 1:]
    distance = np.linalg.norm(chroma - np.median(chroma[border], axis=0), axis=2)
    lightness = lab[..., 0]
    dark = lightness < MIN_WALL_LIGHTNESS * np.quantile(lightness[border], WALL_SHADE)
    face = np.zeros((height, width), np.uint8)
    cv2.fillPoly(face, [prior.oval], 1)
    face_distance = float(np.median(distance[face > 0]))
    return np.asarray((distance > min(MAX_KEY_DISTANCE, face_distance / 2)) | dark, dtype=np.uint8)


def _initial_labels(image: NDArray[np.uint8], prior: BodyPrior) -> Mask:
    """Return GrabCut's labels (H, W) from the expected position of the body."""
    labels = np.full(image.shape[:2], cv2.GC_BGD, np.uint8)
    labels[prior.draw(image.shape, PROBABLE_BACKGROUND) > 0] = cv2.GC_PR_BGD
    labels[prior.draw(image.shape, PROBABLE_FOREGROUND) > 0] = cv2.GC_PR_FGD
    labels[prior.draw(image.shape, SURE_FOREGROUND) > 0] = cv2.GC_FGD
    return labels


class _GrabCut:
    """GrabCut of one image, an iteration at a time; returns (H, W) uint8, 1 where the person is."""

    def __init__(self, image: NDArray[np.uint8], labels: Mask) -> None:
        self._image, self._labels = image.copy(), labels.copy()
        self._models = np.zeros((2, 1, 65))
        self._mode = cv2.GC_INIT_WITH_MASK

    def iterate(self) -> Mask:
        foreground = np.isin(self._labels, (cv2.GC_FGD, cv2.GC_PR_FGD))
        if min(foreground.sum(), (~foreground).sum()) < MIN_AREA_PX:
            return foreground.astype(np.uint8)
        cv2.setRNGSeed(1)  # GrabCut's mixtures start at random: the same image must give the same mask
        cv2.grabCut(self._image, self._labels, (0, 0, 1, 1), self._models[0], self._models[1], 1, self._mode)
        self._mode = cv2.GC_EVAL
        return np.isin(self._labels, (cv2.GC_FGD, cv2.GC_PR_FGD)).astype(np.uint8)


def _clean(mask: Mask, oval: NDArray[np.int32]) -> Mask:
    """Return the connected part of a mask that holds the face, without holes and fringes."""
    mask, oval = cv2.copyMakeBorder(mask, *4 * (PADDING,), cv2.BORDER_REPLICATE), oval + PADDING  # type: ignore[assignment]
    cv2.fillPoly(mask, [oval], 1)
    mask = np.asarray(cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)), np.uint8)
    _, labels = cv2.connectedComponents(mask)
    x, y = np.clip(oval.mean(axis=0).astype(int), 0, np.array(mask.shape)[::-1] - 1)
    mask = (labels == labels[y, x]).astype(np.uint8)
    mask = np.asarray(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((7, 7), np.uint8)), np.uint8)
    soft = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), 1.5)
    return np.asarray(soft > 0.5, dtype=np.uint8)[PADDING:-PADDING, PADDING:-PADDING]


def _trace_outline(mask: Mask) -> NDArray[np.float64]:
    height, width = mask.shape
    found, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not found:
        return np.empty((0, 2))
    outline = max(found, key=cv2.contourArea)
    tolerance = 0.5
    while len(corners := cv2.approxPolyDP(outline, tolerance, True)) > MAX_CORNERS:
        tolerance *= 1.2
    return np.asarray(corners[:, 0] / (width - 1, height - 1), dtype=np.float64)
