"""Find out whether a clip or a camera is upside down or lies on its side, though nothing in the file says so.

The tracker follows such a face, but places upright landmarks on it. The detector shows the difference: on 100 frames of
18 clips it gave 0.89 to 0.97 to upright faces and at most 0.85 to the same faces upside down; of a face on its side it
finds the eyes one above the other. Each image is therefore examined in the four orientations. Faces smaller than a
tenth of the image are taken as upright.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.sender.capture.camera import Camera
from conf.sender.capture.frame import Frame
from conf.sender.tracking.detector import DetectedFace, FaceDetector

if TYPE_CHECKING:
    from conf.sender.capture.clip import Clip  # with PyAV, which a camera does not need

MIN_SCORE = 0.75  # of the best orientation; clouds and walls stay below 0.7, faces tilted by 30 degrees reach 0.8
MIN_MARGIN = 0.05  # between the best orientation and the frame as it is
VOTES = 3  # images in a row that must agree before anything is turned; one is enough to leave it as it is
MAX_SIDE = 640  # px: images are reduced to this size, and the detector uses 128 px
SCAN_FRAMES = 1000  # a face that appears later in a clip is taken as upright
SCAN_STEP = 10  # frames of a clip between two images examined
CAMERA_STEP = 5  # the same of a camera
NAMES = {1: "lies on its side", 2: "is upside down", 3: "lies on its side"}


class OrientationEstimator:
    """Decides after one to a few images by how many quarter turns, counterclockwise, they have to be turned.

    turns : 0 to 3, None while undecided
    suspicious : whether the last image looked as if it had to be turned
    """

    def __init__(self, detector: FaceDetector, /, *, candidates: Sequence[int] = (0, 1, 2, 3)) -> None:
        """candidates : the turns that are possible, 0 first"""
        self._detector = detector
        self._candidates = candidates
        self._votes: Counter[int] = Counter()
        self.turns: int | None = None
        self.suspicious = False

    def add(self, pixels: NDArray[np.uint8], /) -> int | None:
        """Examine an image (H, W, 3) uint8 BGR and return `turns`; an image without a clear face changes nothing."""
        best = self._best_turns(pixels)
        self.suspicious = best not in (None, 0)
        if best is not None:
            self._votes[best] += 1
            if best == 0 or self._votes[best] == VOTES:
                self.turns = best
        return self.turns

    def _best_turns(self, pixels: NDArray[np.uint8]) -> int | None:
        scale = MAX_SIDE / max(pixels.shape[:2])
        small = cv2.resize(pixels, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA) if scale < 1 else pixels
        scores = {}
        for turns in self._candidates:
            turned = np.ascontiguousarray(np.rot90(small, turns), np.uint8)
            faces = self._detector.detect(turned, small_faces=False)
            scores[turns] = uprightness(faces[0]) if faces else 0.0
        best = max(scores, key=lambda turns: scores[turns])
        if scores[best] < MIN_SCORE or (best and scores[best] - scores[0] < MIN_MARGIN):
            return None
        return best


def uprightness(face: DetectedFace, /) -> float:
    """Return the detector's score times the cosine of the angle between the line of the eyes and the image's x axis."""
    across = face.eyes[1] - face.eyes[0]
    return float(face.score * across[0] / max(float(np.linalg.norm(across)), 1e-9))


def open_upright_clip(
    path: Path,
    models: Path,
    /,
    *,
    loop: bool = False,
    is_paced: bool = False,
    on_note: Callable[[str], None] = lambda text: None,
) -> "Clip":
    """Open a clip as `open_clip`, and turn its frames if the face in it is not upright. Raises CameraError, ModelError.

    models : folder of the tracker's files; on_note : told when the frames are turned
    """
    from conf.sender.capture.clip import open_clip

    turns = find_turns(path, FaceDetector(models))
    if turns:
        on_note(f"{path} {NAMES[turns]}: its frames are turned")
    return open_clip(path, loop=loop, turns=turns, is_paced=is_paced)


def find_turns(path: Path, detector: FaceDetector, /) -> int:
    """Return the quarter turns, counterclockwise, that make the first face in a clip upright."""
    from conf.sender.capture.clip import open_clip

    estimator = OrientationEstimator(detector)
    with open_clip(path) as clip:
        for number in range(SCAN_FRAMES):
            frame = clip.read()
            if frame is None or estimator.turns is not None:
                break
            if number % SCAN_STEP == 0 or estimator.suspicious:
                estimator.add(frame.pixels)
    return estimator.turns or 0


class UprightCamera:
    """A camera whose images are turned if it is mounted upside down.

    fps, size : those of the camera
    """

    is_live = True

    def __init__(
        self, camera: Camera, detector: FaceDetector, /, *, on_note: Callable[[str], None] = lambda text: None
    ) -> None:
        """on_note : told when the images are turned"""
        self.fps, self.size = camera.fps, camera.size
        self._camera = camera
        self._estimator = OrientationEstimator(detector, candidates=(0, 2))
        self._on_note = on_note
        self._number = 0

    def read(self) -> Frame:
        """Return the camera's next image, upright. Images that look upside down are held back until it is decided.

        Raises CameraError as the camera does.
        """
        frame = self._camera.read()
        if self._estimator.turns is None and self._number % CAMERA_STEP == 0:
            turns = self._estimator.add(frame.pixels)
            while turns is None and self._estimator.suspicious:
                frame = self._camera.read()
                turns = self._estimator.add(frame.pixels)
            if turns:
                self._on_note(f"the camera {NAMES[2]}: its images are turned")
        self._number += 1
        if self._estimator.turns:
            return Frame(np.ascontiguousarray(frame.pixels[::-1, ::-1]), frame.timestamp)
        return frame

    def release(self) -> None:
        """Release the device until the next read."""
        self._camera.release()
