"""Measure what a viewer of a portrait notices outside the similarity of the face: artefacts, and shut lids.

Artefacts: pixels outside the face that show what the camera has never shown there. Lids: the colour of closed eyes.
"""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.portrait import contours
from conf.sender.tracking.tracker import TrackedFace

ARTEFACT_DISTANCE = 30.0  # of 255, RMS over the colours: sensor noise and coding stay below 15
BLUR_PX = 1.0  # an edge that is half a pixel off is no artefact
HISTORY_FRAMES = 3  # every third earlier frame is compared
LIDS = ((contours.UPPER_LID_R, contours.LOWER_LID_R), (contours.UPPER_LID_L, contours.LOWER_LID_L))
SHUT_RATIO = 0.4  # of the clip's median opening: below it an eye is shut
LID_MARGIN = 0.12  # of the eye's width, around its opening
LID_BLUR = 0.1  # of the eye's width: lashes that are a pixel off change no colour

Pixels = NDArray[np.uint8]
Image = NDArray[np.float32]


def artefact_fractions(
    sources: Sequence[Pixels], shown: Sequence[Pixels | None], trackings: Sequence[TrackedFace | None]
) -> list[float | None]:
    """Return for each image the fraction of pixels outside the face that are artefacts.

    An artefact is farther than ARTEFACT_DISTANCE from the source frame and from every earlier source frame at its
    position. None where nothing is shown or the source has no face.
    """
    fractions: list[float | None] = []
    history: list[Image] = []
    for number, (source, image, tracking) in enumerate(zip(sources, shown, trackings, strict=True)):
        blurred = _blur(source, BLUR_PX)
        if number % HISTORY_FRAMES == 0:
            history.append(blurred)
        if image is None or tracking is None:
            fractions.append(None)
            continue
        hull = cv2.convexHull(np.rint(tracking.landmarks[:, :2]).astype(np.int32))
        face = cv2.fillConvexPoly(np.zeros(source.shape[:2], np.uint8), hull, 1) > 0
        candidate = _blur(image, BLUR_PX)
        odd = ~face & (colour_distance(candidate, blurred) > ARTEFACT_DISTANCE)
        for earlier in reversed(history):
            if not odd.any():
                break
            odd[odd] = colour_distance(candidate[odd], earlier[odd]) > ARTEFACT_DISTANCE
        fractions.append(float(odd.sum() / max(int((~face).sum()), 1)))
    return fractions


def lid_distances(
    sources: Sequence[Pixels], shown: Sequence[Pixels | None], trackings: Sequence[TrackedFace | None]
) -> list[float | None]:
    """Return the mean colour distance of each image's shut lids from the source's, of 255; None if none is shut."""
    gaps = np.array([_eye_gaps(t.landmarks) if t is not None else (np.nan, np.nan) for t in trackings])
    limits = SHUT_RATIO * np.nanmedian(gaps, axis=0) if np.isfinite(gaps).any() else np.zeros(2)
    distances: list[float | None] = []
    for source, image, tracking, gap in zip(sources, shown, trackings, gaps, strict=True):
        shut = [lid for lid, g, limit in zip(LIDS, gap, limits, strict=True) if g < limit]
        if image is None or tracking is None or not shut:
            distances.append(None)
            continue
        distances.append(float(np.mean([_lid_distance(source, image, tracking.landmarks, lid) for lid in shut])))
    return distances


def colour_distance(a: NDArray[np.floating], b: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return the root mean square difference over the last axis."""
    return np.asarray(np.sqrt(np.mean(np.square(a - b), axis=-1)), np.float64)


def _eye_gaps(landmarks: NDArray[np.floating]) -> list[float]:
    """Return the opening of the right and the left eye, of the eye's width."""
    gaps = []
    for upper, lower in LIDS:
        width = np.linalg.norm(landmarks[upper[0], :2] - landmarks[upper[-1], :2])
        middle = len(upper) // 2
        gap = np.linalg.norm(landmarks[upper[middle], :2] - landmarks[lower[middle], :2])
        gaps.append(float(gap / max(float(width), 1e-6)))
    return gaps


def _lid_distance(
    source: Pixels, image: Pixels, landmarks: NDArray[np.floating], lid: tuple[tuple[int, ...], tuple[int, ...]]
) -> float:
    points = landmarks[list(lid[0] + lid[1]), :2]
    width = float(np.linalg.norm(landmarks[lid[0][0], :2] - landmarks[lid[0][-1], :2]))
    area = cv2.fillConvexPoly(np.zeros(source.shape[:2], np.uint8), cv2.convexHull(np.rint(points).astype(np.int32)), 1)
    side = max(1, round(LID_MARGIN * width)) * 2 + 1
    area = cv2.dilate(area, np.ones((side, side), np.uint8))
    blur = max(LID_BLUR * width, 0.5)
    distance = colour_distance(_blur(source, blur), _blur(image, blur))[area > 0]
    return float(distance.mean()) if distance.size else 0.0


def _blur(pixels: Pixels, sigma: float) -> Image:
    return np.asarray(cv2.GaussianBlur(pixels.astype(np.float32), (0, 0), sigma), np.float32)
