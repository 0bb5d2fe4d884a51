"""Predict 478 landmarks in the square of an image that contains a face.

Source: Kartynnik et al. 2019, Real-time Facial Surface Geometry; Grishchenko et al. 2020, Attention Mesh; the crops
are those of MediaPipe's face_landmark graphs.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.sender.tracking.inference import Backend, load_network
from conf.sender.tracking.model_files import LANDMARKS

LANDMARK_COUNT = 478
INPUT_SIZE = 256  # px
CROP_SCALE = 1.5  # side of the crop over the long side of the face
RIGHT_EYE, LEFT_EYE = 33, 263  # the subject's outer corners: the crop is rotated until they are level


@dataclass(frozen=True)
class Crop:
    """A square of the image, upright with the face.

    centre : (2,) px, x right, y down
    side : px
    angle : radians, from the image's x axis to the crop's, clockwise on the screen
    """

    centre: NDArray[np.float64]
    side: float
    angle: float

    @classmethod
    def around_points(cls, points: NDArray[np.floating], eyes: NDArray[np.floating]) -> Self:
        """Return the crop around points (K, 2) px in which the eyes (2, 2) px, right and left, are level."""
        low, high = points.min(axis=0), points.max(axis=0)
        across = eyes[1] - eyes[0]
        return cls(
            centre=np.asarray((low + high) / 2, dtype=np.float64),
            side=float(np.max(high - low)) * CROP_SCALE,
            angle=float(np.arctan2(across[1], across[0])),
        )

    @classmethod
    def around_landmarks(cls, landmarks: NDArray[np.floating]) -> Self:
        """Return the crop for the next frame from this frame's landmarks (478, 3) px."""
        flat = landmarks[:, :2]
        return cls.around_points(flat, flat[[RIGHT_EYE, LEFT_EYE]])

    def matrix(self) -> NDArray[np.float64]:
        """Return the (2, 3) affine map from crop pixels to image pixels."""
        scale = self.side / INPUT_SIZE
        cos, sin = np.cos(self.angle) * scale, np.sin(self.angle) * scale
        rotation = np.array([[cos, -sin], [sin, cos]])
        return np.column_stack([rotation, self.centre - rotation @ np.full(2, INPUT_SIZE / 2)])


class LandmarkNetwork:
    """The landmark network with its pre- and postprocessing."""

    def __init__(self, models: Path, /, *, backend: Backend = "auto") -> None:
        """Load the network from a folder of the tracker's files. Raises ModelError."""
        self._network = load_network(models / LANDMARKS, ("Identity", "Identity_1"), backend=backend)

    def predict(self, pixels: NDArray[np.uint8], crop: Crop, /) -> tuple[NDArray[np.float32], float]:
        """Return landmarks (478, 3) float32 px and the probability, 0 to 1, that the crop shows a face.

        pixels : (H, W, 3) uint8 BGR
        Landmarks: x right, y down, z away from the camera, all in image pixels.
        """
        matrix = crop.matrix()
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        square = cv2.warpAffine(pixels, matrix, (INPUT_SIZE, INPUT_SIZE), flags=flags, borderMode=cv2.BORDER_REPLICATE)
        values = cv2.cvtColor(square, cv2.COLOR_BGR2RGB)[None] * np.float32(1 / 255)
        points, logit = self._network(values)
        in_crop = points.reshape(LANDMARK_COUNT, 3).astype(np.float64)
        landmarks = np.empty((LANDMARK_COUNT, 3), dtype=np.float32)
        landmarks[:, :2] = in_crop[:, :2] @ matrix[:, :2].T + matrix[:, 2]
        landmarks[:, 2] = in_crop[:, 2] * (crop.side / INPUT_SIZE)
        return landmarks, float(1 / (1 + np.exp(-float(logit.reshape(-1)[0]))))
