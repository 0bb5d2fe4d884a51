"""Facial motion tracks as the sender would send them: what the codec is trained on and measured with.

A track holds the landmarks of a clip. They are resampled to the profile's frame rate and go through the sender's own
blendshapes, calibration, smoothing and FAPU, so that the codec meets here what it meets in a call.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.protocol.messages import MotionFrame
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.tracking.blendshape_network import BlendshapeNetwork
from conf.sender.tracking.canonical_face import read_canonical_face
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.pose_removal import remove_head_pose
from conf.sender.tracking.tracker import TrackedFace

RIGHT_EYE, LEFT_EYE = 33, 263  # the outer corners: their distance is what errors are measured against


@dataclass(frozen=True)
class Track:
    """One clip's motion at one frame rate.

    frames : N frames, timestamps from 0
    eye_distance : (N,) float64, between the outer eye corners in the picture, picture heights
    lengths : (n, 3) float64, cm, one FAPU unit of each axis of each control point, of this person
    """

    name: str
    frames: list[MotionFrame]
    eye_distance: NDArray[np.float64]
    lengths: NDArray[np.float64]

    def picture_errors(
        self, index: int, displacements: NDArray[np.floating], pose: NDArray[np.floating], /
    ) -> NDArray[np.float64]:
        """Return how far the control points of decoded motion lie from those of frame `index`.

        Both are put on the mean face with this person's FAPU and seen by the camera that the pose tells.
        Returns (n,) per cent of the eye distance in that frame.
        """
        true = self.frames[index]
        shown = project(displacements * self.lengths, pose)
        meant = project(true.displacements * self.lengths, true.pose)
        return np.asarray(100 * np.linalg.norm(shown - meant, axis=1) / self.eye_distance[index])


@dataclass(frozen=True)
class StillFace:
    """One frame.

    landmarks : (478, 3) px; aligned : the same in cm, without the head's pose; size : of the picture, px
    neutral : (n, 3) cm, control points of the neutral pose in use
    """

    landmarks: NDArray[np.float32]
    size: tuple[int, int]
    aligned: NDArray[np.float64]
    motion: MotionFrame
    neutral: NDArray[np.float64]


def project(offsets: NDArray[np.floating], pose: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return where control points moved by `offsets` (n, 3) cm are in the picture, (n, 2) picture heights."""
    head = HeadPose.from_vector(pose)
    turned = (MEAN_FACE + offsets) @ head.matrix().T
    return np.asarray(np.exp(head.log_scale) * turned[:, :2] + head.position)


class TrackReader:
    """Reads track files and turns them into motion."""

    def __init__(self) -> None:
        """Open the tracker's files, fetching them if need be. Raises ModelError."""
        models = fetch_models()
        self._canonical = read_canonical_face(models)
        self._blendshapes = BlendshapeNetwork(models)

    def read(self, path: Path, /, *, fps: float) -> Track:
        """Read the first unbroken run of frames with a face, resampled to `fps` by linear interpolation."""
        landmarks, size = _load(path, fps)
        extractor = MotionExtractor(self._canonical, size)
        frames = [self._motion(extractor, points, number / fps) for number, points in enumerate(landmarks)]
        corners = landmarks[:, RIGHT_EYE, :2] - landmarks[:, LEFT_EYE, :2]
        eye_distance = np.linalg.norm(corners.astype(np.float64), axis=1) / size[1]
        return Track(path.stem, frames, eye_distance, extractor.fapu.lengths())

    def still_faces(self, path: Path, /, *, fps: float) -> Iterator[StillFace]:
        """Yield the frames of `read` as a photograph would have them."""
        landmarks, size = _load(path, fps)
        extractor = MotionExtractor(self._canonical, size)
        for number, points in enumerate(landmarks):
            motion = self._motion(extractor, points, number / fps)
            aligned, _ = remove_head_pose(points, self._canonical, size)
            yield StillFace(points, size, aligned, motion, extractor.neutral_points)

    def _motion(self, extractor: MotionExtractor, points: NDArray[np.float32], timestamp: float) -> MotionFrame:
        return extractor.update(TrackedFace(points, self._blendshapes.predict(points), presence=1.0), timestamp)


def _load(path: Path, fps: float) -> tuple[NDArray[np.float32], tuple[int, int]]:
    """Return (N, 478, 3) px and the picture's width and height."""
    with np.load(path) as file:
        landmarks = file["landmarks"][_first_run(file["tracked"])] / float(file["scale"])
        size = int(file["width"]), int(file["height"])
        source_fps = float(file["fps"])
    return _resample(landmarks, source_fps / fps).astype(np.float32), size


def _first_run(tracked: NDArray[np.bool_]) -> slice:
    start = int(np.argmax(tracked))
    lost = np.flatnonzero(~tracked[start:])
    return slice(start, start + int(lost[0]) if len(lost) else len(tracked))


def _resample(values: NDArray[np.floating], step: float) -> NDArray[np.float64]:
    """Return the values at every `step`-th frame, in between by linear interpolation."""
    at = np.arange(0, len(values) - 1 + 1e-9, step)
    before = np.minimum(at.astype(int), len(values) - 2)
    share = (at - before)[:, None, None]
    return np.asarray(values[before] * (1 - share) + values[before + 1] * share)
