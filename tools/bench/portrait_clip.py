"""Read frames for the portrait benches and compare shown images with their source."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.portrait import contours
from conf.sender.capture.clip import open_clip
from conf.sender.tracking.tracker import FaceTracker, TrackedFace

SIZE = (320, 240)
FPS = 15
MIN_S = 30.0  # length of a looped clip
START_S = 10.0
EYE_CORNERS = (33, 263)
MOUTH_MARGIN = 0.25  # added on each side of the bounding box of the mouth, relative to its size
_C1, _C2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2  # the constants of SSIM

Pixels = NDArray[np.uint8]


def load_frames(path: Path, /) -> list[Pixels]:
    """Return all frames of a clip at 320x240 and 15 frames/s, cropped to the central 4:3 area."""
    frames: list[Pixels] = []
    with open_clip(path) as source:
        for frame in iter(source.read, None):
            if frame.timestamp >= len(frames) / FPS - 0.5 / source.fps:
                frames.append(_fit(frame.pixels))
    return frames


def looped(frames: Sequence[Pixels], /) -> list[Pixels]:
    """Return the frames, repeated until they last MIN_S."""
    rounds = max(1, -(-round(MIN_S * FPS) // len(frames)))
    return (list(frames) * rounds)[: max(len(frames), round(MIN_S * FPS))]


def unlooped(frames: Sequence[Pixels], /) -> list[Pixels]:
    """Return frames of which those after START_S come only once: the first half, repeated until then, and the second.

    A clip of at least MIN_S stays as it is.
    """
    if len(frames) >= round(MIN_S * FPS):
        return list(frames)
    half, start = len(frames) // 2, round(START_S * FPS)
    first = (list(frames[: max(half, 1)]) * -(-start // max(half, 1)))[-start:]  # ends where the second half begins
    return first + list(frames[half:])


def _fit(pixels: Pixels) -> Pixels:
    height, width = pixels.shape[:2]
    w, h = min(width, height * 4 // 3), min(height, width * 3 // 4)
    x, y = (width - w) // 2, (height - h) // 2
    interpolation = cv2.INTER_AREA if w >= SIZE[0] else cv2.INTER_CUBIC
    return np.asarray(cv2.resize(pixels[y : y + h, x : x + w], SIZE, interpolation=interpolation), dtype=np.uint8)


@dataclass(frozen=True)
class Similarity:
    """Similarity of one image with its source; `landmark_error_percent` is None if no face was found in the image."""

    face_ssim: float
    mouth_ssim: float
    face_psnr: float
    mouth_psnr: float
    landmark_error_percent: float | None


def compare(source: Pixels, shown: Pixels, tracking: TrackedFace, shown_tracking: TrackedFace | None, /) -> Similarity:
    """Compare an image with its source, within the outline of the face and the box of the mouth in the source."""
    lips = tracking.landmarks[list(contours.UPPER_OUTER_LIP + contours.LOWER_OUTER_LIP), :2]
    face, mouth = _outline(tracking.landmarks[:, :2]), _box(lips, MOUTH_MARGIN)
    quality = ssim_map(source, shown)
    error = None
    if shown_tracking is not None:
        eye_distance = np.linalg.norm(np.diff(tracking.landmarks[list(EYE_CORNERS), :2], axis=0))
        offsets = np.linalg.norm((shown_tracking.landmarks - tracking.landmarks)[:, :2], axis=1)
        error = float(100 * offsets.mean() / eye_distance)
    return Similarity(
        float(quality[face].mean()),
        float(quality[mouth].mean()),
        psnr(source[face], shown[face]),
        psnr(source[mouth], shown[mouth]),
        error,
    )


def ssim_map(a: Pixels, b: Pixels, /) -> NDArray[np.float64]:
    """Return (H, W), the structural similarity of the luma around each pixel.

    Source: Wang, Bovik, Sheikh, Simoncelli 2004, with their window: Gaussian, 11 px, standard deviation 1.5 px.
    """
    x, y = (cv2.cvtColor(p, cv2.COLOR_BGR2GRAY).astype(np.float64) for p in (a, b))
    mx, my = _blur(x), _blur(y)
    vx, vy, cross = _blur(x * x) - mx * mx, _blur(y * y) - my * my, _blur(x * y) - mx * my
    return np.asarray((2 * mx * my + _C1) * (2 * cross + _C2) / ((mx * mx + my * my + _C1) * (vx + vy + _C2)))


def _blur(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(cv2.GaussianBlur(values, (11, 11), 1.5))


def psnr(a: Pixels, b: Pixels, /) -> float:
    """Return the peak signal to noise ratio in dB over all three colours."""
    error = float(np.mean((a.astype(np.float64) - b) ** 2))
    return 10 * float(np.log10(255**2 / max(error, 1e-3)))


def _outline(points: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Return (H, W) bool: the inside of the convex hull of the points."""
    mask = np.zeros(SIZE[::-1], np.uint8)
    cv2.fillConvexPoly(mask, np.rint(cv2.convexHull(points.astype(np.float32))).astype(np.int32), 1)
    return mask > 0


def _box(points: NDArray[np.floating], margin: float) -> tuple[slice, slice]:
    low, high = points.min(axis=0), points.max(axis=0)
    spread = margin * (high - low)
    x0, y0 = np.clip(np.floor(low - spread), 0, (SIZE[0] - 8, SIZE[1] - 8)).astype(int)
    x1, y1 = np.clip(np.ceil(high + spread), (x0 + 8, y0 + 8), SIZE).astype(int)
    return slice(y0, y1), slice(x0, x1)


def similarities(
    sources: Sequence[Pixels],
    shown: Sequence[Pixels | None],
    trackings: Sequence[TrackedFace | None],
    tracker: FaceTracker,
) -> list[Similarity | None]:
    """Compare all images; None where the source has no face or nothing is shown."""
    result: list[Similarity | None] = []
    for source, image, tracking in zip(sources, shown, trackings, strict=True):
        if image is None or tracking is None:
            result.append(None)
            continue
        result.append(compare(source, image, tracking, tracker.track(image)))
    return result


def average(rows: Sequence[Similarity | None], /) -> dict[str, float | None]:
    """Return the mean of each figure; `not_found` is the fraction of images in which no face was found."""
    compared = [row for row in rows if row is not None]
    if not compared:
        return {}
    errors = [row.landmark_error_percent for row in compared if row.landmark_error_percent is not None]
    names = ("face_ssim", "mouth_ssim", "face_psnr", "mouth_psnr")
    means = {name: float(np.mean([getattr(row, name) for row in compared])) for name in names}
    figures: dict[str, float | None] = {name: round(mean, 4) for name, mean in means.items()}
    figures["landmark_error_percent"] = round(float(np.mean(errors)), 3) if errors else None
    figures["not_found"] = round(1 - len(errors) / len(compared), 4)
    return figures
