"""Follow one face from frame to frame: detector, then landmarks, which give the next frame's crop."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.sender.tracking.blendshape_network import BlendshapeNetwork
from conf.sender.tracking.detector import DetectedFace, FaceDetector
from conf.sender.tracking.inference import Backend, choose_backend
from conf.sender.tracking.landmarks import Crop, LandmarkNetwork

# In how many frames once: what LiteRT does in 0.4 ms takes OpenCV 1.6 ms, and calibration can wait two frames.
BLENDSHAPES_EVERY = {"litert": 1, "opencv": 3}
MIN_PRESENCE = 0.5
MAX_CANDIDATES = 3  # how many of the detector's finds are looked at in one frame
MAX_LANDMARK_SHIFT = (
    0.03  # between two looks at one face, of its size: on faces at most 0.015, on lettering 0.05 and up
)


@dataclass(frozen=True)
class TrackedFace:
    """A face in one frame.

    landmarks : (478, 3) float32 px, x right, y down, z away from the camera
    blendshapes : (52,) float32, 0 to 1, named in conf.sender.tracking.blendshape_network
    presence : 0 to 1, how sure the network is that this is a face
    blendshapes_age : how many frames ago the blendshapes were found
    """

    landmarks: NDArray[np.float32]
    blendshapes: NDArray[np.float32]
    presence: float
    blendshapes_age: int = 0


class FaceTracker:
    """Finds a face and keeps to it; when it is lost, finds one again."""

    def __init__(self, models: Path, /, *, backend: Backend = "auto") -> None:
        """Open the networks in a folder of the tracker's files. Raises ModelError."""
        self.backend = choose_backend(backend)
        self._detector = FaceDetector(models, backend=backend)
        self._landmarks = LandmarkNetwork(models, backend=backend)
        self._blendshapes = BlendshapeNetwork(models, backend=backend)
        self._crop: Crop | None = None
        self._last_shapes: NDArray[np.float32] | None = None
        self._shapes_age = 0

    def track(self, pixels: NDArray[np.uint8], /) -> TrackedFace | None:
        """Return the face in the next frame (H, W, 3) uint8 BGR, or None if it shows none."""
        found = self._follow(pixels) or self._search(pixels)
        if found is None:
            self._crop = self._last_shapes = None
            return None
        landmarks, presence = found
        self._crop = Crop.around_landmarks(landmarks)
        shapes = self._find_blendshapes(landmarks)
        return TrackedFace(landmarks, shapes, presence, self._shapes_age)

    def _find_blendshapes(self, landmarks: NDArray[np.float32]) -> NDArray[np.float32]:
        self._shapes_age += 1
        if self._last_shapes is None or self._shapes_age >= BLENDSHAPES_EVERY[self.backend]:
            self._last_shapes, self._shapes_age = self._blendshapes.predict(landmarks), 0
        return self._last_shapes

    def _follow(self, pixels: NDArray[np.uint8]) -> tuple[NDArray[np.float32], float] | None:
        """Look where the face was."""
        return None if self._crop is None else self._predict_landmarks(pixels, self._crop)

    def _search(self, pixels: NDArray[np.uint8]) -> tuple[NDArray[np.float32], float] | None:
        """Look everywhere, the most prominent face first.

        Each find gets a second look, from the crop that its landmarks ask for: on a face it gives the same landmarks,
        on a cloud or a word, which the networks now and then take for a face, it gives others.
        """
        for face in self._detector.detect(pixels)[:MAX_CANDIDATES]:
            rough = self._predict_landmarks(pixels, _crop_around_face(face))
            fine = rough and self._predict_landmarks(pixels, Crop.around_landmarks(rough[0]))
            if rough and fine and _disagreement(rough[0], fine[0]) <= MAX_LANDMARK_SHIFT * face.side:
                return fine
        return None

    def _predict_landmarks(self, pixels: NDArray[np.uint8], crop: Crop) -> tuple[NDArray[np.float32], float] | None:
        landmarks, presence = self._landmarks.predict(pixels, crop)
        return (landmarks, presence) if presence >= MIN_PRESENCE else None


def _crop_around_face(face: DetectedFace) -> Crop:
    return Crop.around_points(face.box.reshape(2, 2), face.eyes)


def _disagreement(a: NDArray[np.float32], b: NDArray[np.float32]) -> float:
    """Return the mean distance in the picture, px, between two sets of landmarks (478, 3)."""
    return float(np.linalg.norm((a - b)[:, :2], axis=1).mean())
