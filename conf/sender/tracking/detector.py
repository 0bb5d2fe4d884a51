"""Detect faces in an image, while there is none to follow from frame to frame.

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

INPUT_SIZE = 128  # px
MIN_SCORE = 0.5
MAX_IOU = 0.3  # detections that overlap more are one face
TILE_SIDE = 0.5  # of the image's short side: finds faces down to a twentieth of the image


@dataclass(frozen=True)
class DetectedFace:
    """A face in the image: px, x right, y down.

    box : (4,) float64, left, top, right, bottom
    eyes : (2, 2) float64, the subject's right eye, then the left
    score : 0 to 1
    """

    box: NDArray[np.float64]
    eyes: NDArray[np.float64]
    score: float

    @property
    def side(self) -> float:
        """Return the long side of the box."""
        return float(np.max(self.box[2:] - self.box[:2]))


class FaceDetector:
    """The detector network with its pre- and postprocessing."""

    def __init__(self, models: Path, /, *, backend: Backend = "auto") -> None:
        """Load the network from a folder of the tracker's files. Raises ModelError."""
        self._network = load_network(models / DETECTOR, ("regressors", "classificators"), backend=backend)
        self._anchors = make_anchors()

    def detect(self, pixels: NDArray[np.uint8], /, *, small_faces: bool = True) -> list[DetectedFace]:
        """Return the faces in an image (H, W, 3) uint8 BGR, large and central ones first.

        small_faces : search the image in tiles as well if there is no face larger than a tenth of it, for ten times
        the time
        """
        height, width = pixels.shape[:2]
        side = max(height, width)
        faces = self._detect_in_square(pixels, ((width - side) / 2, (height - side) / 2), side)
        if (
            not faces and small_faces and min(width, height) >= INPUT_SIZE
        ):  # smaller tiles would be enlarged and show nothing new
            found = [self._detect_in_square(pixels, corner, side) for corner, side in tiles(width, height)]
            faces = weighted_nms([face for part in found for face in part])
        middle = np.array([width, height]) / 2
        return sorted(faces, key=lambda face: -caller_score(face, middle))

    def _detect_in_square(
        self, pixels: NDArray[np.uint8], corner: tuple[float, float], side: float
    ) -> list[DetectedFace]:
        """Run the network on one square of the image, black outside the image."""
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
    """Return (896, 2): the centres that the network's outputs are relative to, 0 to 1 in the square.

    Two for each cell of a 16 x 16 grid, six for each cell of an 8 x 8 grid.
    """
    grids = []
    for cells, anchors_per_cell in ((16, 2), (8, 6)):
        centres = (np.arange(cells) + 0.5) / cells
        y, x = np.meshgrid(centres, centres, indexing="ij")
        grids.append(np.repeat(np.stack([x.ravel(), y.ravel()], axis=1), anchors_per_cell, axis=0))
    return np.concatenate(grids)


def decode(
    regressors: NDArray[np.floating], anchors: NDArray[np.float64], /
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the boxes (K, 4) and eyes (K, 2, 2), 0 to 1 in the square, of the network's outputs.

    regressors : (K, 16): x, y, width, height, six key points, in px of the network's input, relative to the anchor
    anchors : (K, 2)
    """
    values = np.asarray(regressors, dtype=np.float64).reshape(-1, 8, 2) / INPUT_SIZE
    centres = anchors + values[:, 0]
    half = values[:, 1] / 2
    return np.concatenate([centres - half, centres + half], axis=1), anchors[:, None] + values[:, 2:4]


def weighted_nms(faces: list[DetectedFace], /) -> list[DetectedFace]:
    """Merge overlapping detections by weighted non-maximum suppression: boxes and eyes are averaged by score."""
    rest = sorted(faces, key=lambda face: -face.score)
    merged = []
    while rest:
        best = rest[0]
        near = [face for face in rest if face is best or iou(best.box, face.box) > MAX_IOU]
        weights = np.array([face.score for face in near])
        box = np.average([face.box for face in near], axis=0, weights=weights)
        eyes = np.average([face.eyes for face in near], axis=0, weights=weights)
        merged.append(DetectedFace(box, eyes, best.score))
        rest = [face for face in rest if not any(face is other for other in near)]
    return merged


def iou(a: NDArray[np.float64], b: NDArray[np.float64], /) -> float:
    """Return the intersection over union of two boxes (4,)."""
    intersection = np.prod(np.maximum(0, np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2])))
    union = np.prod(a[2:] - a[:2]) + np.prod(b[2:] - b[:2]) - intersection
    return float(intersection / union) if union > 0 else 0.0


def tiles(width: int, height: int, /) -> Iterator[tuple[tuple[float, float], float]]:
    """Yield corner and side of squares that cover an image, each overlapping its neighbours by half."""
    side = min(width, height) * TILE_SIDE
    for top in np.linspace(0, height - side, 1 + int(np.ceil(2 * (height - side) / side))):
        for left in np.linspace(0, width - side, 1 + int(np.ceil(2 * (width - side) / side))):
            yield (float(left), float(top)), side


def caller_score(face: DetectedFace, middle: NDArray[np.float64], /) -> float:
    """Return a face's size, reduced by up to a half with the distance from the image's middle (2,)."""
    distance = np.linalg.norm(face.box.reshape(2, 2).mean(axis=0) - middle) / np.linalg.norm(middle)
    return float(face.side * (1 - distance / 2))
