"""Choose and cut patches: pictures of mouth and eyes in moments that no patch shows yet.

Strategy: the keys of a feature (`patch_features`) say what it does. A frame whose keys are far from those of
the photograph and of every patch is worth a patch. Slots are few: when they are full, the patch that is nearest to
another one, so that it would be missed least, makes room. Light is matched here, where both pictures are at hand: a
patch takes over the photograph's colours along its border.
"""

from bisect import bisect_left
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from conf.face.control_points import CONTROL_POINT_LANDMARKS
from conf.face.portrait.patch_features import PatchRegion
from conf.face.portrait.patch_prediction import forward_dct
from conf.protocol.portrait.patch import MAX_SIDE, MAX_SLOTS, STEP_COUNT, Patch, encode_patch, step_size

MARGIN = 1.1  # of the reach: the patch ends where it would not be seen any more


@dataclass(frozen=True)
class PatchBudget:
    """What patches of a feature may cost, and how different they must be.

    size : bytes of one
    slots : how many are kept, at most MAX_SLOTS
    novelty : key steps from the nearest that is kept
    """

    size: int
    slots: int
    novelty: float

    def __post_init__(self) -> None:
        if not 0 < self.slots <= MAX_SLOTS:
            raise ValueError(f"slots must be 1 to {MAX_SLOTS}, got {self.slots}")


class PatchSet:
    """The patches of one feature on one photograph, as the receiver has or will have them."""

    def __init__(self, feature: PatchRegion, budget: PatchBudget, photo_key: NDArray[np.int8], /) -> None:
        self._feature = feature
        self._budget = budget
        self._photo = photo_key.astype(np.float64)
        self._keys: dict[int, NDArray[np.float64]] = {}

    def novelty(self, key: NDArray[np.int8], /) -> float:
        """Return how far a moment is from all that the receiver can show; from 1 on it deserves a patch."""
        known = np.array([self._photo, *self._keys.values()])
        return float(np.linalg.norm(known - key, axis=1).min()) / self._budget.novelty

    def assign_slot(self, key: NDArray[np.int8], /) -> int:
        """Keep a moment; return the slot it goes to."""
        free = [slot for slot in range(self._budget.slots) if slot not in self._keys]
        slot = free[0] if free else self._most_redundant()
        self._keys[slot] = key.astype(np.float64)
        return slot

    def _most_redundant(self) -> int:
        def alone(slot: int) -> float:
            others = [self._photo, *(k for s, k in self._keys.items() if s != slot)]
            return float(np.linalg.norm(np.array(others) - self._keys[slot], axis=1).min())

        return min(self._keys, key=alone)


@dataclass(frozen=True)
class PatchCrop:
    """A feature cut out of a frame.

    pixels : (h, w, 3) uint8 BGR
    points : (m, 2) where the feature's control points lie in it, 0 to 1 from its upper left corner
    seen : (h, w) 0 to 1, what of it a patch would show
    """

    pixels: NDArray[np.uint8]
    points: NDArray[np.float64]
    seen: NDArray[np.float64]


@dataclass(frozen=True)
class CropBox:
    """Where a feature is cut out of a frame: corners low and high (2,), px; points (m, 2) in between, 0 to 1."""

    low: NDArray[np.intp]
    high: NDArray[np.intp]
    points: NDArray[np.float64]


def place_cut(
    landmarks: NDArray[np.floating], feature: PatchRegion, size: tuple[int, int], /, *, centimetre: float
) -> CropBox:
    """Return where to cut. landmarks : (478, 3) px; size : of the frame, px; centimetre : its length in px."""
    core = landmarks[list(feature.centre_landmarks), :2]
    margin = MARGIN * feature.falloff_cm[1] * centimetre
    low = np.maximum(np.floor(core.min(axis=0) - margin), 0).astype(int)
    high = np.minimum(np.ceil(core.max(axis=0) + margin), size).astype(int)
    low, high = np.minimum(low, np.array(size) - 8), np.maximum(high, low + 8)
    points = (landmarks[CONTROL_POINT_LANDMARKS[list(feature.points)], :2] - low) / (high - low)
    return CropBox(low, high, points.astype(np.float64))


def extract_patch(
    pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], feature: PatchRegion, /, *, centimetre: float
) -> PatchCrop:
    """Cut a feature out of a frame.

    pixels : (H, W, 3) uint8 BGR; landmarks : (478, 3) px; centimetre : its length in px
    """
    place = place_cut(landmarks, feature, (pixels.shape[1], pixels.shape[0]), centimetre=centimetre)
    low, high = place.low, place.high
    crop = pixels[low[1] : high[1], low[0] : high[0]]
    scale = min(1.0, MAX_SIDE / max(crop.shape[:2]))
    small = cv2.resize(crop, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA) if scale < 1 else crop
    rows, columns = small.shape[:2]
    grid = np.stack(np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5), axis=-1) / (columns, rows)
    distance = (
        np.asarray(cKDTree(landmarks[list(feature.centre_landmarks), :2]).query(low + grid * (high - low))[0])
        / centimetre
    )
    return PatchCrop(np.ascontiguousarray(small, np.uint8), place.points, feature.falloff(distance))


def match_colour(patch: NDArray[np.uint8], under: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return a patch (h, w, 3) with the brightness and tint, along its border, of what it is laid on (h, w, 3)."""
    height, width = patch.shape[:2]
    border = np.ones((height, width), bool)
    inset = max(2, min(height, width) // 7)
    border[inset:-inset, inset:-inset] = False
    gain = under[border].mean(axis=0) / np.maximum(patch[border].mean(axis=0), 1)
    return np.asarray(np.clip(patch * np.clip(gain, 0.6, 1.6), 0, 255))


def make_patch(
    difference: NDArray[np.float64],
    points: NDArray[np.float64],
    key: NDArray[np.int8],
    /,
    *,
    target: tuple[int, int, int],
    budget: int,
) -> Patch:
    """Return the patch that travels, as fine as a number of bytes allows, or the coarsest.

    difference : (h, w, 3) what is to be added to what the photograph foretells; points : (m, 2) 0 to 1
    where : photograph, region and slot; budget : bytes
    """
    planes = forward_dct(difference)
    size = difference.shape[1], difference.shape[0]

    def at(step: int) -> Patch:
        return Patch(*target, key, points, size, step, [plane / step_size(step) for plane in planes])

    return at(bisect_left(range(STEP_COUNT - 1), True, key=lambda step: len(encode_patch(at(step))) <= budget))
