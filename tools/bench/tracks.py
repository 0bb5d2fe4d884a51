"""Read facial motion tracks as the sender would send them, to train and to measure the codec.

A track holds the landmarks of a clip. They are resampled to the frame rate of the profile and processed by the sender's
blendshapes, calibration, smoothing and FAPU, so that the codec gets the same motion as in a call.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.face.fapu import Fapu
from conf.face.head_pose import HeadPose
from conf.protocol.messages import MotionFrame
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.motion.neutral_pose import NeutralPoseEstimator
from conf.sender.tracking.blendshape_network import BlendshapeNetwork
from conf.sender.tracking.canonical_face import load_canonical_face, remove_head_pose
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import TrackedFace

RIGHT_EYE, LEFT_EYE = 33, 263  # landmarks of the outer corners; errors are relative to their distance


@dataclass(frozen=True)
class Track:
    """Motion of one clip at one frame rate.

    frames : N frames, timestamps from 0
    eye_distance : (N,) float64, between the outer eye corners in the image, image heights
    fapu : of this person, cm
    aligned : (N, 478, 3) float64, cm, the landmarks with the head pose removed, not smoothed
    """

    name: str
    frames: list[MotionFrame]
    eye_distance: NDArray[np.float64]
    fapu: Fapu
    aligned: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 478, 3)))

    @property
    def lengths(self) -> NDArray[np.float64]:
        """The (n, 3) FAPU, cm, of this person for each axis of each control point."""
        return self.fapu.lengths()

    def image_errors(
        self, index: int, displacements: NDArray[np.floating], pose: NDArray[np.floating], /
    ) -> NDArray[np.float64]:
        """Return the (n,) distances of decoded control points from those of frame `index`, % of its eye distance.

        Both are added to the mean face with this person's FAPU and projected with their pose.
        """
        frame = self.frames[index]
        decoded = project(displacements * self.lengths, pose)
        original = project(frame.displacements * self.lengths, frame.pose)
        return np.asarray(100 * np.linalg.norm(decoded - original, axis=1) / self.eye_distance[index])


@dataclass(frozen=True)
class StillFace:
    """One frame as a photo of the person.

    landmarks : (478, 3) px; aligned : the same in cm, head pose removed; size : of the image, px
    neutral : (n, 3) cm, control points of the current neutral pose
    """

    landmarks: NDArray[np.float32]
    size: tuple[int, int]
    aligned: NDArray[np.float64]
    motion: MotionFrame
    neutral: NDArray[np.float64]


def project(offsets: NDArray[np.floating], pose: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return the (n, 2) image positions, image heights, of control points moved by `offsets` (n, 3), cm."""
    head = HeadPose.from_vector(pose)
    rotated = (MEAN_FACE + offsets) @ head.matrix().T
    return np.asarray(np.exp(head.log_scale) * rotated[:, :2] + head.position)


class TrackReader:
    """Reads track files and extracts their motion."""

    def __init__(self) -> None:
        """Open the tracker's files; fetch them if they are missing. Raises ModelError."""
        models = fetch_models()
        self._canonical = load_canonical_face()
        self._blendshapes = BlendshapeNetwork(models)

    def read(self, path: Path, /, *, fps: float, neutral: NeutralPoseEstimator | None = None) -> Track:
        """Return the first uninterrupted run of frames with a face, resampled to `fps` by linear interpolation.

        neutral : estimator of the neutral pose, None for that of a call
        """
        landmarks, size = _load(path, fps)
        extractor = MotionExtractor(self._canonical, size, neutral=neutral)
        frames = [self._motion(extractor, points, number / fps) for number, points in enumerate(landmarks)]
        corners = landmarks[:, RIGHT_EYE, :2] - landmarks[:, LEFT_EYE, :2]
        eye_distance = np.linalg.norm(corners.astype(np.float64), axis=1) / size[1]
        aligned = np.stack([remove_head_pose(points, self._canonical, size)[0] for points in landmarks])
        return Track(path.stem, frames, eye_distance, extractor.fapu, aligned)

    def motion_and_shapes(self, path: Path, /, *, fps: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the (N, n, 3) displacements, FAPU units, of the frames of `read`, and their (N, 52) blendshapes."""
        landmarks, size = _load(path, fps)
        extractor = MotionExtractor(self._canonical, size)
        shapes = np.stack([self._blendshapes.predict(points) for points in landmarks])
        faces = (TrackedFace(points, shape, presence=1.0) for points, shape in zip(landmarks, shapes, strict=True))
        motion = [extractor.update(face, number / fps).displacements for number, face in enumerate(faces)]
        return np.stack(motion).astype(np.float64), shapes.astype(np.float64)

    def landmarks_and_shapes(self, path: Path, /, *, fps: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the (N, 478, 3) landmarks, cm, without head pose, of the frames of `read`, and (N, 52) shapes."""
        landmarks, size = _load(path, fps)
        aligned = np.stack([remove_head_pose(points, self._canonical, size)[0] for points in landmarks])
        return aligned, np.stack([self._blendshapes.predict(points) for points in landmarks]).astype(np.float64)

    def still_faces(self, path: Path, /, *, fps: float) -> Iterator[StillFace]:
        """Yield the frames of `read` as photos."""
        landmarks, size = _load(path, fps)
        extractor = MotionExtractor(self._canonical, size)
        for number, points in enumerate(landmarks):
            motion = self._motion(extractor, points, number / fps)
            aligned, _ = remove_head_pose(points, self._canonical, size)
            yield StillFace(points, size, aligned, motion, extractor.neutral_points)

    def _motion(self, extractor: MotionExtractor, points: NDArray[np.float32], timestamp: float) -> MotionFrame:
        return extractor.update(TrackedFace(points, self._blendshapes.predict(points), presence=1.0), timestamp)


def _load(path: Path, fps: float) -> tuple[NDArray[np.float32], tuple[int, int]]:
    """Return the landmarks, (N, 478, 3) px, and width and height of the image."""
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
    """Return the values at multiples of `step` frames, linearly interpolated."""
    positions = np.arange(0, len(values) - 1 + 1e-9, step)
    before = np.minimum(positions.astype(int), len(values) - 2)
    weight = (positions - before)[:, None, None]
    return np.asarray(values[before] * (1 - weight) + values[before + 1] * weight)
