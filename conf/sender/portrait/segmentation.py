"""Cut the person out of a picture: by colour before a plain blue or green wall, else by GrabCut from the landmarks.

Source: Rother, Kolmogorov, Blake 2004 (GrabCut); the thesis's set-up had a plain blue background.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.portrait import contours

MAX_CORNERS = 64
WORK_HEIGHT = 120  # px: cutting is done on a small copy
PLAIN_SHARE = 0.75  # of the border that must have the wall's colour
LOWEST_HUE, HIGHEST_HUE = 35, 130  # OpenCV's, 0 to 180: from green to blue
WALL_SATURATION = 20
HUE_SPREAD = 12  # a plain wall is darker here and there, but of one hue
KEY_DISTANCE = 22.0  # in Lab's colour plane, from the wall's colour

LEAST_PX = 20  # of person and of background
STEPS = 8  # of GrabCut, a round each

Mask = NDArray[np.uint8]


def segment_person(pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return the person's outline, (K, 2) 0 to 1 from the upper left corner, at most MAX_CORNERS.

    pixels : (H, W, 3) uint8 BGR; landmarks : (478, 3) px
    """
    *_, outline = segment_steps(pixels, landmarks)
    assert outline is not None, "the last step has the outline"
    return outline


def segment_steps(
    pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], /
) -> Iterator[NDArray[np.float64] | None]:
    """Find the outline of `outline_person` in steps of at most a frame's time each: yield None until it is there."""
    scale = WORK_HEIGHT / len(pixels)
    small = np.asarray(cv2.resize(pixels, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8)
    figure = BodyPrior.of(landmarks[list(contours.OVAL), :2] * scale)
    mask = _by_colour(small, figure)
    if mask is not None:
        mask &= figure.paint(small.shape, CHROMA_KEY_AREA)
    else:
        grown = _HeadAndBodyGrabCut(small, figure)
        for _ in range(STEPS - 1):
            grown.iterate()
            yield None
        mask = grown.iterate()
    mask[figure.paint(small.shape, SURE_FOREGROUND) > 0] = 1
    yield _outline(_smooth(mask, figure.oval))


SUPERELLIPSE = 0.75  # below 1 an ellipse is fuller
Corners = list[tuple[float, float]]


def _ellipse(across: float, up: float, rise: float) -> Corners:
    """Return an ellipse about the face's middle, moved up, fuller above as skulls are: in face widths and heights."""
    angles = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    x, y = np.cos(angles), np.sin(angles)
    fuller = np.where(y < 0, SUPERELLIPSE, 1.0)
    x, y = np.sign(x) * np.abs(x) ** fuller, np.sign(y) * np.abs(y) ** fuller
    return [(across * float(a), -rise + up * float(b)) for a, b in zip(x, y, strict=True)]


# Corners in face widths and heights: of a head from the face's middle, y towards the chin; of a body from the chin.
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
    "body": [(-2.2, 0.3), (-0.6, -0.1), (0.6, -0.1), (2.2, 0.3), (3.2, 1.5), (3.2, 4.0), (-3.2, 4.0), (-3.2, 1.5)],
}
CHROMA_KEY_AREA = {
    # before a plain wall colour tells hair from what stands about: only what is far away is not the person's
    "head": _ellipse(1.7, 1.4, 0.15),
    "body": [(-1.7, -0.2), (1.7, -0.2), (3.2, 1.0), (3.2, 4.0), (-3.2, 4.0), (-3.2, 1.0)],
}


@dataclass(frozen=True)
class BodyPrior:
    """Where a person of usual build is, told by the face.

    oval : (36, 2) int32 px; head, body : (2, 2) from face widths and heights to px; middle, chin : (2,) px
    """

    oval: NDArray[np.int32]
    head: NDArray[np.float64]
    body: NDArray[np.float64]
    middle: NDArray[np.float64]
    chin: NDArray[np.float64]

    @classmethod
    def of(cls, oval: NDArray[np.floating]) -> "BodyPrior":
        """Read the figure off the face's oval (36, 2) px: the head tilts with the face, the body does not."""
        chin, top = oval[contours.OVAL.index(152)], oval[0]
        height = max(float(np.linalg.norm(chin - top)), 1.0)
        down = (chin - top) / height
        across = np.array([down[1], -down[0]])
        width = float(np.ptp(oval @ across))
        return cls(
            np.rint(oval).astype(np.int32),
            np.stack([across * width, down * height]),
            np.diag([width, height]),
            np.asarray((chin + top) / 2, np.float64),
            np.asarray(chin, np.float64),
        )

    def paint(self, shape: tuple[int, ...], parts: dict[str, Corners]) -> Mask:
        """Return (H, W) uint8 with 1 inside head and body as a table has them."""
        mask = np.zeros(shape[:2], np.uint8)
        for corners, axes, origin in ((parts["head"], self.head, self.middle), (parts["body"], self.body, self.chin)):
            cv2.fillPoly(mask, [np.rint(np.array(corners) @ axes + origin).astype(np.int32)], 1)
        cv2.fillPoly(mask, [self.oval], 1)
        return mask


def _by_colour(small: NDArray[np.uint8], figure: BodyPrior) -> Mask | None:
    """Return what is not of the wall's colour, or None where there is no plain blue or green wall."""
    height, width = small.shape[:2]
    border = np.zeros((height, width), bool)
    border[: height // 10] = True
    border[: height // 2, : width // 12] = border[: height // 2, -width // 12 :] = True
    hsv = cv2.cvtColor(small, cv2.COLOR_BGR2HSV)
    hue, saturation = hsv[..., 0][border], hsv[..., 1][border]
    plane = cv2.cvtColor(small, cv2.COLOR_BGR2LAB).astype(np.float32)[..., 1:]
    wall = np.median(plane[border], axis=0)
    middle = float(np.median(hue))
    alike = (np.abs(hue - middle) <= HUE_SPREAD) & (saturation >= WALL_SATURATION)
    if not LOWEST_HUE <= middle <= HIGHEST_HUE or np.mean(alike) < PLAIN_SHARE:
        return None
    face = np.zeros((height, width), np.uint8)
    cv2.fillPoly(face, [figure.oval], 1)
    distance = np.linalg.norm(plane - wall, axis=2)
    far = float(np.median(distance[face > 0]))
    return np.asarray(distance > min(KEY_DISTANCE, far / 2), dtype=np.uint8)


class _HeadAndBodyGrabCut:
    """GrabCut, a round at a time: once more for the head, lest hair be lost that has the colour of a dark room."""

    def __init__(self, small: NDArray[np.uint8], figure: BodyPrior) -> None:
        labels = np.full(small.shape[:2], cv2.GC_BGD, np.uint8)
        for parts, label in (
            (PROBABLE_BACKGROUND, cv2.GC_PR_BGD),
            (PROBABLE_FOREGROUND, cv2.GC_PR_FGD),
            (SURE_FOREGROUND, cv2.GC_FGD),
        ):
            labels[figure.paint(small.shape, parts) > 0] = label
        chin = int(np.clip(figure.chin[1], 0, len(small)))
        self._whole, self._head = _GrabCut(small, labels), _GrabCut(small[:chin], labels[:chin])

    def iterate(self) -> Mask:
        """Go a round on and return (H, W) uint8, 1 where the person is."""
        mask, head = self._whole.iterate(), self._head.iterate()
        mask[: len(head)] |= head
        return mask


class _GrabCut:
    """A part of the picture with colours of its own."""

    def __init__(self, pixels: NDArray[np.uint8], labels: Mask) -> None:
        self._pixels, self._labels = pixels.copy(), labels.copy()
        self._models = np.zeros((2, 1, 65))
        self._mode = cv2.GC_INIT_WITH_MASK

    def iterate(self) -> Mask:
        mine = np.isin(self._labels, (cv2.GC_FGD, cv2.GC_PR_FGD))
        if min(mine.sum(), (~mine).sum()) < LEAST_PX:  # nothing to tell apart, nothing to learn a colour from
            return mine.astype(np.uint8)
        cv2.setRNGSeed(1)  # GrabCut's mixtures start at random: the same picture, the same cut
        cv2.grabCut(self._pixels, self._labels, (0, 0, 1, 1), self._models[0], self._models[1], 1, self._mode)
        self._mode = cv2.GC_EVAL
        return np.isin(self._labels, (cv2.GC_FGD, cv2.GC_PR_FGD)).astype(np.uint8)


def _smooth(mask: Mask, oval: NDArray[np.int32]) -> Mask:
    """Return the part that the face belongs to, without holes, specks and fringes."""
    cv2.fillPoly(mask, [oval], 1)
    mask = np.asarray(cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)), np.uint8)
    _, labels = cv2.connectedComponents(mask)
    x, y = np.clip(oval.mean(axis=0).astype(int), 0, np.array(mask.shape)[::-1] - 1)
    mask = (labels == labels[y, x]).astype(np.uint8)
    mask = np.asarray(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((7, 7), np.uint8)), np.uint8)
    soft = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), 1.5)
    return np.asarray(soft > 0.5, dtype=np.uint8)


def _outline(mask: Mask) -> NDArray[np.float64]:
    height, width = mask.shape
    found, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not found:
        return np.empty((0, 2))
    outline = max(found, key=cv2.contourArea)
    tolerance = 0.5
    while len(corners := cv2.approxPolyDP(outline, tolerance, True)) > MAX_CORNERS:
        tolerance *= 1.2
    return np.asarray(corners[:, 0] / (width - 1, height - 1), dtype=np.float64)
