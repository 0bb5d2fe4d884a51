"""Decide which feature gets a patch, when and in which slot. Pure: fed with displacements and times.

Strategy: the descriptor of a feature (`patch_features`) describes its expression. A frame is worth a patch if its
descriptor is far from those of the photo and of every patch. Slots are few: when all are used, the patch nearest to
another one is replaced, as it is the most redundant.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.patch_features import EYES, FEATURES, MOUTH
from conf.protocol.portrait.patch import MAX_SLOTS
from conf.protocol.rate_control.rate_limit import TokenBucket

PATCH_BYTES = {MOUTH.name: 150, EYES.name: 180}
MIN_NOVELTY = 6.0  # descriptor steps from the nearest image that the receiver has
MAX_WAITING_BYTES = 700  # no new patch while more than this is unacknowledged
BYTES_PER_SECOND = 115  # long-term limit of patches, however much the face moves
BURST_BYTES = 1600


class PatchSet:
    """The patches of one feature that the receiver has or will have, for one photo."""

    def __init__(self, photo_descriptor: NDArray[np.int8], /, *, slots: int = MAX_SLOTS) -> None:
        self._slots = slots
        self._photo = photo_descriptor.astype(np.float64)
        self._patches: dict[int, NDArray[np.float64]] = {}  # descriptors by slot

    def novelty(self, descriptor: NDArray[np.int8], /) -> float:
        """Return the distance, in descriptor steps, from the nearest of the photo and all patches."""
        return _min_distance(descriptor, [self._photo, *self._patches.values()])

    def assign_slot(self, descriptor: NDArray[np.int8], /) -> int:
        """Add a patch; return the first free slot, or the slot of the most redundant patch, which it replaces."""
        free = (slot for slot in range(self._slots) if slot not in self._patches)
        slot = next(free, None)
        if slot is None:
            slot = min(self._patches, key=self._redundancy_distance)
        self._patches[slot] = descriptor.astype(np.float64)
        return slot

    def _redundancy_distance(self, slot: int) -> float:
        others = [self._photo, *(patch for other, patch in self._patches.items() if other != slot)]
        return _min_distance(self._patches[slot], others)


def _min_distance(descriptor: NDArray[np.int8] | NDArray[np.float64], others: list[NDArray[np.float64]]) -> float:
    return float(np.linalg.norm(np.array(others) - descriptor, axis=1).min())


class PatchScheduler:
    """Requests patches for one photo after the other, within a byte rate."""

    def __init__(self) -> None:
        self._sets: list[PatchSet] = []
        self._budget = TokenBucket(BYTES_PER_SECOND, BURST_BYTES)

    def set_photo(self, displacements: NDArray[np.floating]) -> None:
        """Start without patches on a photo that shows these displacements (n, 3), FAPU units."""
        self._sets = [PatchSet(feature.quantised_descriptor(displacements)) for feature in FEATURES]

    def next_request(
        self, displacements: NDArray[np.floating], now: float, *, waiting_bytes: int, can_patch: Callable[[int], bool]
    ) -> tuple[int, int, NDArray[np.int8]] | None:
        """Return region, slot and descriptor of the patch to make of a frame, None if it needs none or may have none.

        displacements : (n, 3) FAPU units
        waiting_bytes : of all objects, not yet acknowledged
        can_patch : whether the feature of a region can be cut from the frame; costly, so it is called last
        """
        if waiting_bytes > MAX_WAITING_BYTES:
            return None
        descriptors = [feature.quantised_descriptor(displacements) for feature in FEATURES]
        novelties = [patches.novelty(d) for patches, d in zip(self._sets, descriptors, strict=True)]
        region = int(np.argmax(novelties))
        max_bytes = PATCH_BYTES[FEATURES[region].name]
        if novelties[region] < MIN_NOVELTY or not can_patch(region) or not self._budget.consume(max_bytes, now):
            return None
        slot = self._sets[region].assign_slot(descriptors[region])
        return region, slot, descriptors[region]
