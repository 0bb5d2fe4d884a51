"""Follow one face from frame to frame: detector, then landmarks, which give the next frame's crop."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.sender.blendshapes import BlendshapeFinder
from conf.sender.detector import Face, FaceDetector
from conf.sender.landmarks import Crop, LandmarkFinder
from conf.sender.network import Backend

MIN_PRESENCE = 0.5


@dataclass(frozen=True)
class Tracking:
    """A face in one frame.

    landmarks : (478, 3) float32 px, x right, y down, z away from the camera
    blendshapes : (52,) float32, 0 to 1, named in conf.sender.blendshapes
    presence : 0 to 1, how sure the network is that this is a face
    """

    landmarks: NDArray[np.float32]
    blendshapes: NDArray[np.float32]
    presence: float


class FaceTracker:
    """Finds a face and keeps to it; when it is lost, finds one again."""

    def __init__(self, models: Path, /, *, backend: Backend = "auto") -> None:
        """Open the networks in a folder of the tracker's files. Raises ModelError."""
        self._detector = FaceDetector(models, backend=backend)
        self._landmarks = LandmarkFinder(models, backend=backend)
        self._blendshapes = BlendshapeFinder(models, backend=backend)
        self._crop: Crop | None = None

    def track(self, pixels: NDArray[np.uint8], /) -> Tracking | None:
        """Return the face in the next frame (H, W, 3) uint8 BGR, or None if it shows none."""
        found = self._follow(pixels) or self._search(pixels)
        if found is None:
            self._crop = None
            return None
        landmarks, presence = found
        self._crop = Crop.around_landmarks(landmarks)
        return Tracking(landmarks, self._blendshapes.find(landmarks), presence)

    def _follow(self, pixels: NDArray[np.uint8]) -> tuple[NDArray[np.float32], float] | None:
        """Look where the face was."""
        return None if self._crop is None else self._look(pixels, self._crop)

    def _search(self, pixels: NDArray[np.uint8]) -> tuple[NDArray[np.float32], float] | None:
        """Look everywhere, the most prominent face first."""
        for face in self._detector.find(pixels):
            rough = self._look(pixels, _crop_around_face(face))
            if rough is not None:
                # The detector's crop is loose: a second look from the landmarks' own starts the track where it stays.
                return self._look(pixels, Crop.around_landmarks(rough[0])) or rough
        return None

    def _look(self, pixels: NDArray[np.uint8], crop: Crop) -> tuple[NDArray[np.float32], float] | None:
        landmarks, presence = self._landmarks.find(pixels, crop)
        return (landmarks, presence) if presence >= MIN_PRESENCE else None


def _crop_around_face(face: Face) -> Crop:
    return Crop.around(face.box.reshape(2, 2), face.eyes)
