"""Find faces in a picture: where to look, before there is anything to follow.

Source: Bazarevsky et al. 2019, BlazeFace; the anchors, scales and thresholds are those of MediaPipe's
face_detector_graph.cc (short range).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.sender.tracking.inference import Backend, load_network
from conf.sender.tracking.model_files import DETECTOR

INPUT_SIZE = 128
MIN_SCORE = 0.5
MAX_OVERLAP = 0.3  # detections that overlap more than this are one face
TILE_SHARE = 0.5  # side of a tile over the picture's short side: finds faces down to a twentieth of the picture


@dataclass(frozen=True)
class DetectedFace:
    """A face found, in pixels of the picture: x right, y down.

    box : (4,) float64, left, top, right, bottom
    eyes : (2, 2) float64, the subject's right eye, then the left
    score : 0 to 1
    """

    box: NDArray[np.float64]
    eyes: NDArray[np.float64]
    score: float

    @property
    def centre(self) -> NDArray[np.float64]:
        """Return (2,): the middle of the box."""
        return (self.box[:2] + self.box[2:]) / 2

    @property
    def side(self) -> float:
        """Return the long side of the box."""
        return float(np.max(self.box[2:] - self.box[:2]))


class FaceDetector:
    """The detector network with what goes before and after it."""

    def __init__(self, models: Path, /, *, backend: Backend = "auto") -> None:
        """Open the network in a folder of the tracker's files. Raises ModelError."""
        self._network = load_network(models / DETECTOR, ("regressors", "classificators"), backend=backend)
        self._anchors = make_anchors()

    def detect(self, pixels: NDArray[np.uint8], /) -> list[DetectedFace]:
        """Return the faces in a picture, the best to follow first: large and central.

        pixels : (H, W, 3) uint8 BGR
        """
        height, width = pixels.shape[:2]
        whole = max(height, width)
        corner = ((width - whole) / 2, (height - whole) / 2)
        faces = self._find_in_square(pixels, corner, whole)
        if not faces and min(width, height) >= INPUT_SIZE:  # smaller tiles would show it nothing new
            found = [self._find_in_square(pixels, corner, side) for corner, side in tiles(width, height)]
            faces = weighted_nms([face for part in found for face in part])
        middle = np.array([width, height]) / 2
        return sorted(faces, key=lambda face: -caller_score(face, middle))

    def _find_in_square(
        self, pixels: NDArray[np.uint8], corner: tuple[float, float], side: float
    ) -> list[DetectedFace]:
        """Run the network on one square of the picture, black where it leaves the picture."""
        scale = INPUT_SIZE / side
        matrix = np.array([[scale, 0, -corner[0] * scale], [0, scale, -corner[1] * scale]])
        square = cv2.warpAffine(pixels, matrix, (INPUT_SIZE, INPUT_SIZE), flags=cv2.INTER_LINEAR)
        values = cv2.cvtColor(square, cv2.COLOR_BGR2RGB)[None] * np.float32(1 / 127.5) - np.float32(1)
        regressors, logits = self._network(values)
        scores = 1 / (1 + np.exp(-np.clip(logits.reshape(-1), -80, 80)))
        likely = np.flatnonzero(scores >= MIN_SCORE)
        boxes, eyes = decode(regressors.reshape(-1, 16)[likely], self._anchors[likely])
        offset = np.array(corner)
        return weighted_nms(
            [
                DetectedFace((box.reshape(2, 2) * side + offset).reshape(4), pair * side + offset, float(score))
                for box, pair, score in zip(boxes, eyes, scores[likely], strict=True)
            ]
        )


def make_anchors() -> NDArray[np.float64]:
    """Return (896, 2): the centres that the network's answers are relative to, in shares of the square's side.

    Two for each cell of a 16 x 16 grid, six for each cell of an 8 x 8 grid.
    """
    grids = []
    for cells, anchors_a_cell in ((16, 2), (8, 6)):
        centres = (np.arange(cells) + 0.5) / cells
        y, x = np.meshgrid(centres, centres, indexing="ij")
        grids.append(np.repeat(np.stack([x.ravel(), y.ravel()], axis=1), anchors_a_cell, axis=0))
    return np.concatenate(grids)


def decode(
    regressors: NDArray[np.floating], anchors: NDArray[np.float64], /
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Turn the network's answers into boxes (K, 4) and eyes (K, 2, 2), in shares of the square's side.

    regressors : (K, 16): x, y, width, height, six key points, in pixels of the network's input, from the anchor
    anchors : (K, 2)
    """
    values = np.asarray(regressors, dtype=np.float64).reshape(-1, 8, 2) / INPUT_SIZE
    centres = anchors + values[:, 0]
    half = values[:, 1] / 2
    return np.concatenate([centres - half, centres + half], axis=1), anchors[:, None] + values[:, 2:4]


def weighted_nms(faces: list[DetectedFace], /) -> list[DetectedFace]:
    """Weighted non-maximum suppression: the mean, by score, of the detections that overlap the best one, and so on."""
    rest = sorted(faces, key=lambda face: -face.score)
    merged = []
    while rest:
        best = rest[0]
        near = [face for face in rest if face is best or iou(best.box, face.box) > MAX_OVERLAP]
        weights = np.array([face.score for face in near])
        box = np.average([face.box for face in near], axis=0, weights=weights)
        eyes = np.average([face.eyes for face in near], axis=0, weights=weights)
        merged.append(DetectedFace(box, eyes, best.score))
        rest = [face for face in rest if not any(face is other for other in near)]
    return merged


def iou(a: NDArray[np.float64], b: NDArray[np.float64], /) -> float:
    """Return the intersection over union of two boxes (4,)."""
    shared = np.prod(np.maximum(0, np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2])))
    union = np.prod(a[2:] - a[:2]) + np.prod(b[2:] - b[:2]) - shared
    return float(shared / union) if union > 0 else 0.0


def tiles(width: int, height: int, /) -> Iterator[tuple[tuple[float, float], float]]:
    """Yield the corner and side of squares that cover a picture, each overlapping its neighbours by half."""
    side = min(width, height) * TILE_SHARE
    for top in np.linspace(0, height - side, 1 + int(np.ceil(2 * (height - side) / side))):
        for left in np.linspace(0, width - side, 1 + int(np.ceil(2 * (width - side) / side))):
            yield (float(left), float(top)), side


def caller_score(face: DetectedFace, middle: NDArray[np.float64], /) -> float:
    """Return how much a face looks like the caller's: its size, less the farther it is from the middle (2,)."""
    away = np.linalg.norm(face.centre - middle) / np.linalg.norm(middle)
    return float(face.side * (1 - away / 2))
