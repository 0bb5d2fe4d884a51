"""Follow one face from frame to frame: the detector finds it, its landmarks give the next frame's crop."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.sender.tracking.blendshape_network import BlendshapeNetwork
from conf.sender.tracking.detector import FaceDetector
from conf.sender.tracking.inference import Backend, choose_backend
from conf.sender.tracking.landmarks import Crop, LandmarkNetwork

# Frames between two predictions: each costs LiteRT 0.4 ms and OpenCV 1.6 ms, and calibration can wait two frames.
BLENDSHAPE_INTERVAL = {"litert": 1, "opencv": 3}
MIN_PRESENCE = 0.5
MAX_CANDIDATES = 3  # detections examined in one frame
# Mean shift of the landmarks between two predictions, of the face's size: at most 0.015 on faces, from 0.05 on letters.
MAX_LANDMARK_SHIFT = 0.03

Landmarks = tuple[NDArray[np.float32], float]  # (478, 3) px, presence


@dataclass(frozen=True)
class TrackedFace:
    """A face in one frame.

    landmarks : (478, 3) float32 px, x right, y down, z away from the camera
    blendshapes : (52,) float32, 0 to 1, named in conf.sender.tracking.blendshape_network
    presence : 0 to 1, the network's confidence that this is a face
    blendshapes_age : frames since the blendshapes were predicted
    """

    landmarks: NDArray[np.float32]
    blendshapes: NDArray[np.float32]
    presence: float
    blendshapes_age: int = 0


class FaceTracker:
    """Detects a face and follows it; detects again when it is lost."""

    def __init__(self, models: Path, /, *, backend: Backend = "auto") -> None:
        """Load the networks from a folder of the tracker's files. Raises ModelError."""
        self.backend = choose_backend(backend)
        self._detector = FaceDetector(models, backend=backend)
        self._landmarks = LandmarkNetwork(models, backend=backend)
        self._blendshapes = BlendshapeNetwork(models, backend=backend)
        self._crop: Crop | None = None
        self._last_shapes: NDArray[np.float32] | None = None
        self._shapes_age = 0

    def track(self, pixels: NDArray[np.uint8], /) -> TrackedFace | None:
        """Return the face in the next frame (H, W, 3) uint8 BGR, or None if it shows none."""
        found = (self._crop and self._predict_landmarks(pixels, self._crop)) or self._detect(pixels)
        if found is None:
            self._crop = self._last_shapes = None
            return None
        landmarks, presence = found
        self._crop = Crop.around_landmarks(landmarks)
        self._shapes_age += 1
        if self._last_shapes is None or self._shapes_age >= BLENDSHAPE_INTERVAL[self.backend]:
            self._last_shapes, self._shapes_age = self._blendshapes.predict(landmarks), 0
        return TrackedFace(landmarks, self._last_shapes, presence, self._shapes_age)

    def _detect(self, pixels: NDArray[np.uint8]) -> Landmarks | None:
        """Search the whole frame, the most likely caller first.

        Landmarks are predicted twice, the second time in the crop that the first ones give: on a face they agree; on a
        cloud or letters, which the networks sometimes mistake for a face, they do not.
        """
        for face in self._detector.detect(pixels)[:MAX_CANDIDATES]:
            first = self._predict_landmarks(pixels, Crop.around_points(face.box.reshape(2, 2), face.eyes))
            second = first and self._predict_landmarks(pixels, Crop.around_landmarks(first[0]))
            if first and second:
                shift = float(np.linalg.norm((first[0] - second[0])[:, :2], axis=1).mean())
                if shift <= MAX_LANDMARK_SHIFT * face.side:
                    return second
        return None

    def _predict_landmarks(self, pixels: NDArray[np.uint8], crop: Crop) -> Landmarks | None:
        landmarks, presence = self._landmarks.predict(pixels, crop)
        return (landmarks, presence) if presence >= MIN_PRESENCE else None
