"""Choose and cut patches: pictures of mouth and eyes in moments that no patch shows yet.

Strategy: the keys of a feature (conf.face.portrait.features) say what it does. A frame whose keys are far from those of
the photograph and of every patch is worth a patch. Slots are few: when they are full, the patch that is nearest to
another one, so that it would be missed least, makes room. Light is matched here, where both pictures are at hand: a
patch takes over the photograph's colours along its border.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import LANDMARKS
from conf.face.portrait.features import Feature
from conf.protocol.portrait.patch import MAX_SLOTS, Patch
from conf.sender.portrait.encoding import encode_picture

MAX_SIDE = 96  # px
MARGIN = 1.1  # of the reach: the patch ends where it would not be seen any more


@dataclass(frozen=True)
class PatchBudget:
    """What patches of a feature may cost, and how different they must be.

    size : bytes of one picture
    slots : how many are kept, at most MAX_SLOTS
    novelty : key steps from the nearest that is kept
    """

    size: int
    slots: int
    novelty: float

    def __post_init__(self) -> None:
        if not 0 < self.slots <= MAX_SLOTS:
            raise ValueError(f"slots must be 1 to {MAX_SLOTS}, got {self.slots}")


class Patchwork:
    """The patches of one feature on one photograph, as the receiver has or will have them."""

    def __init__(self, feature: Feature, budget: PatchBudget, photo_key: NDArray[np.int8], /) -> None:
        self._feature = feature
        self._budget = budget
        self._photo = photo_key.astype(np.float64)
        self._keys: dict[int, NDArray[np.float64]] = {}

    def novelty(self, key: NDArray[np.int8], /) -> float:
        """Return how far a moment is from all that the receiver can show; from 1 on it deserves a patch."""
        known = np.array([self._photo, *self._keys.values()])
        return float(np.linalg.norm(known - key, axis=1).min()) / self._budget.novelty

    def take(self, key: NDArray[np.int8], /) -> int:
        """Keep a moment; return the slot it goes to."""
        free = [slot for slot in range(self._budget.slots) if slot not in self._keys]
        slot = free[0] if free else self._least_missed()
        self._keys[slot] = key.astype(np.float64)
        return slot

    def _least_missed(self) -> int:
        def alone(slot: int) -> float:
            others = [self._photo, *(k for s, k in self._keys.items() if s != slot)]
            return float(np.linalg.norm(np.array(others) - self._keys[slot], axis=1).min())

        return min(self._keys, key=alone)


def cut_patch(
    pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], feature: Feature, /, *, centimetre: float
) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """Cut a feature out of a frame.

    pixels : (H, W, 3) uint8 BGR; landmarks : (478, 3) px; centimetre : its length in px
    Returns the cut-out and where the feature's control points lie in it, (m, 2) from its upper left corner.
    """
    height, width = pixels.shape[:2]
    core = landmarks[list(feature.core), :2]
    margin = MARGIN * feature.reach[1] * centimetre
    low = np.maximum(np.floor(core.min(axis=0) - margin), 0).astype(int)
    high = np.minimum(np.ceil(core.max(axis=0) + margin), (width, height)).astype(int)
    low, high = np.minimum(low, (width - 8, height - 8)), np.maximum(high, low + 8)
    crop = pixels[low[1] : high[1], low[0] : high[0]]
    points = landmarks[LANDMARKS[list(feature.points)], :2]
    scale = min(1.0, MAX_SIDE / max(crop.shape[:2]))
    small = cv2.resize(crop, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA) if scale < 1 else crop
    return np.ascontiguousarray(small, dtype=np.uint8), np.asarray((points - low) / (high - low), np.float64)


def match_light(
    patch: NDArray[np.uint8],
    points: NDArray[np.float64],
    photo: NDArray[np.uint8],
    photo_points: NDArray[np.float64],
    /,
) -> NDArray[np.uint8]:
    """Return the patch with the photograph's brightness and tint along its border.

    points, photo_points : (m, 2) the feature's control points in either picture, 0 to 1
    """
    height, width = patch.shape[:2]
    size, photo_size = np.array([width, height]), np.array(photo.shape[1::-1])
    to_photo = similarity(points * size, photo_points * photo_size)
    under = cv2.warpAffine(photo, to_photo, (width, height), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    border = np.ones((height, width), bool)
    inset = max(2, min(height, width) // 7)
    border[inset:-inset, inset:-inset] = False
    gain = under[border].mean(axis=0) / np.maximum(patch[border].mean(axis=0), 1)
    return np.asarray(np.clip(patch * np.clip(gain, 0.6, 1.6), 0, 255), dtype=np.uint8)


def similarity(source: NDArray[np.float64], target: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return the (2, 3) matrix that turns, sizes and shifts points (m, 2) nearest to others, in least squares."""
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    over = max(float(np.sum(a * a)), 1e-9)
    cosine, sine = float(np.sum(a * b)) / over, float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])) / over
    turn = np.array([[cosine, -sine], [sine, cosine]])
    return np.column_stack([turn, target.mean(axis=0) - turn @ source.mean(axis=0)])


def make_patch(
    pixels: NDArray[np.uint8], points: NDArray[np.float64], key: NDArray[np.int8], /, *, where: tuple[int, int, int],
    budget: int,
) -> Patch:  # fmt: skip
    """Return the patch that travels. `where` is photograph, region and slot."""
    return Patch(*where, key, points, encode_picture(pixels, budget=budget, best=80))
