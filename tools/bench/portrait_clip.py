"""Frames for the portrait's bench, and how like its source a shown picture is."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.portrait import contours
from conf.sender.capture.video import open_clip
from conf.sender.tracking.tracker import FaceTracker, TrackedFace

SIZE = (320, 240)
FPS = 15
LEAST_S = 30.0
START_S = 10.0
EYE_CORNERS = (33, 263)
MOUTH_MARGIN = 0.25  # of the mouth's box, on each side
_C1, _C2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2  # the constants of SSIM

Pixels = NDArray[np.uint8]


def load_frames(path: Path, /) -> list[Pixels]:
    """Return a clip at 320x240 and 15 frames a second, as long as it is: the middle of it that is 4 to 3."""
    frames: list[Pixels] = []
    with open_clip(path) as source:
        for frame in iter(source.read, None):
            if frame.timestamp >= len(frames) / FPS - 0.5 / source.fps:
                frames.append(_fit(frame.pixels))
    return frames


def looped(frames: Sequence[Pixels], /) -> list[Pixels]:
    """Return the frames, again and again until they last LEAST_S."""
    rounds = max(1, -(-round(LEAST_S * FPS) // len(frames)))
    return (list(frames) * rounds)[: max(len(frames), round(LEAST_S * FPS))]


def _fit(pixels: Pixels) -> Pixels:
    height, width = pixels.shape[:2]
    w, h = min(width, height * 4 // 3), min(height, width * 3 // 4)
    x, y = (width - w) // 2, (height - h) // 2
    how = cv2.INTER_AREA if w >= SIZE[0] else cv2.INTER_CUBIC
    return np.asarray(cv2.resize(pixels[y : y + h, x : x + w], SIZE, interpolation=how), dtype=np.uint8)


@dataclass(frozen=True)
class Likeness:
    """How like its source one shown picture is; `landmark_error_percent` is None where the tracker finds no face."""

    face_ssim: float
    mouth_ssim: float
    face_psnr: float
    mouth_psnr: float
    landmark_error_percent: float | None


def compare(source: Pixels, shown: Pixels, tracking: TrackedFace, again: TrackedFace | None, /) -> Likeness:
    """Compare a shown picture with its source, in the face's outline and the mouth's box, as the source has them."""
    lips = tracking.landmarks[list(contours.UPPER_OUTER_LIP + contours.LOWER_OUTER_LIP), :2]
    face, mouth = _outline(tracking.landmarks[:, :2]), _box(lips, MOUTH_MARGIN)
    quality = ssim_map(source, shown)
    error = None
    if again is not None:
        eyes = np.linalg.norm(np.diff(tracking.landmarks[list(EYE_CORNERS), :2], axis=0))
        offsets = np.linalg.norm((again.landmarks - tracking.landmarks)[:, :2], axis=1)
        error = float(100 * offsets.mean() / eyes)
    return Likeness(
        float(quality[face].mean()),
        float(quality[mouth].mean()),
        psnr(source[face], shown[face]),
        psnr(source[mouth], shown[mouth]),
        error,
    )


def ssim_map(a: Pixels, b: Pixels, /) -> NDArray[np.float64]:
    """Return (H, W), the structural similarity of the brightness around each pixel.

    Source: Wang, Bovik, Sheikh, Simoncelli 2004, with their window (Gaussian, 11 pixels, deviation 1.5).
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
    """Return (H, W) bool: what lies within the outermost of the points."""
    mask = np.zeros(SIZE[::-1], np.uint8)
    cv2.fillConvexPoly(mask, np.rint(cv2.convexHull(points.astype(np.float32))).astype(np.int32), 1)
    return mask > 0


def _box(points: NDArray[np.floating], margin: float) -> tuple[slice, slice]:
    low, high = points.min(axis=0), points.max(axis=0)
    spread = margin * (high - low)
    x0, y0 = np.clip(np.floor(low - spread), 0, (SIZE[0] - 8, SIZE[1] - 8)).astype(int)
    x1, y1 = np.clip(np.ceil(high + spread), (x0 + 8, y0 + 8), SIZE).astype(int)
    return slice(y0, y1), slice(x0, x1)


def likenesses(
    sources: Sequence[Pixels],
    shown: Sequence[Pixels | None],
    trackings: Sequence[TrackedFace | None],
    tracker: FaceTracker,
) -> list[Likeness | None]:
    """Compare a row of pictures; None where there is no face in the source or nothing is shown."""
    result: list[Likeness | None] = []
    for source, picture, tracking in zip(sources, shown, trackings, strict=True):
        if picture is None or tracking is None:
            result.append(None)
            continue
        result.append(compare(source, picture, tracking, tracker.track(picture)))
    return result


def average(rows: Sequence[Likeness | None], /) -> dict[str, float | None]:
    """Return the mean of each figure; `not_found` is the share of pictures in which the tracker finds no face."""
    seen = [row for row in rows if row is not None]
    if not seen:
        return {}
    errors = [row.landmark_error_percent for row in seen if row.landmark_error_percent is not None]
    names = ("face_ssim", "mouth_ssim", "face_psnr", "mouth_psnr")
    figures: dict[str, float | None] = {n: round(float(np.mean([getattr(row, n) for row in seen])), 4) for n in names}
    figures["landmark_error_percent"] = round(float(np.mean(errors)), 3) if errors else None
    figures["not_found"] = round(1 - len(errors) / len(seen), 4)
    return figures
