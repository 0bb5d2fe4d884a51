"""Decide which feature of which recent frame gets a patch, and in which slot. Pure: fed with frames and times.

Strategy: the descriptor of a feature (`patch_features`) describes its expression. The receiver shows the image with the
nearest descriptor, so each recent frame has a cost, which grows with its distance from the nearest image. Of the frames
of the last ten seconds, the next patch shows the one that reduces the sum of all costs most: an expression that is far
from all images, or one that is seen often. It need not be seen again when there are bytes for it. Slots are few: when
all are used, a patch replaces the one whose loss costs least.
Source: Nemhauser, Wolsey, Fisher 1978 (greedy selection for facility location).
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.patch_features import EYES, FEATURES, MOUTH
from conf.protocol.portrait.patch import MAX_SLOTS
from conf.protocol.rate_control.rate_limit import TokenBucket
from conf.sender.portrait.recent_frames import RecentFrame

PATCH_BYTES = {MOUTH.name: 150, EYES.name: 180}
MIN_NOVELTY = 6.0  # descriptor steps of a frame with a patch from the nearest image that the receiver has
COST_POWER = 0.5  # of the distance: similarity falls fast at first, images that are far away are equally wrong
PATCH_MEMORY = 3.0  # recent frames that a patch counts as: expressions come back after more than ten seconds
MAX_WAITING_BYTES = 700  # no new patch while more than this is unacknowledged
BYTES_PER_SECOND = 115  # long-term limit of patches, however much the face moves
BURST_BYTES = 1600
# Of a view that is being sent, which arrive before the next patch: patches have a third of the rate meanwhile.
VIEW_BYTES_PER_PATCH = 300

Descriptors = NDArray[np.float64]


class PatchSet:
    """The patches of one feature that the receiver has or will have, for one photo."""

    def __init__(self, photo_descriptor: NDArray[np.int8], /, *, slots: int = MAX_SLOTS) -> None:
        self._slots = slots
        self._photo = photo_descriptor.astype(np.float64)
        self._patches: dict[int, Descriptors] = {}  # by slot

    def gains(
        self, frames: Descriptors, below: Descriptors | None = None, /
    ) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        """Return (N,) by how much a patch of each frame reduces the sum of all costs, and (N,) its slot.

        frames : (N, k) descriptors. A frame nearer than MIN_NOVELTY to an image has a gain of 0.
        below : (N, k) descriptors of what photo and views show in each frame; the photo's if None
        """
        slots = list(self._patches)
        patches = np.array([self._patches[slot] for slot in slots]).reshape(len(slots), len(self._photo))
        shown = np.concatenate([frames, patches])
        weights = np.concatenate([np.ones(len(frames)), np.full(len(slots), PATCH_MEMORY)])
        images = _costs(shown, np.concatenate([self._photo[None], patches]))  # (N + M, 1 + M)
        if below is not None:
            images[: len(frames), 0] = np.linalg.norm(frames - below, axis=1) ** COST_POWER
        nearest = images.min(axis=1)
        candidates = _costs(shown, frames)  # (N + M, N)
        free = next((slot for slot in range(self._slots) if slot not in self._patches), None)
        if free is not None:
            gains = weights @ np.maximum(nearest[:, None] - candidates, 0)
            chosen = np.full(len(frames), free, np.intp)
        else:
            without = np.stack([np.delete(images, 1 + i, axis=1).min(axis=1) for i in range(len(slots))])  # (M, N + M)
            sums = np.stack([weights @ np.minimum(each[:, None], candidates) for each in without])  # (M, N)
            gains = weights @ nearest - sums.min(axis=0)
            chosen = np.array(slots, np.intp)[sums.argmin(axis=0)]
        return np.where(nearest[: len(frames)] < MIN_NOVELTY**COST_POWER, 0.0, gains), chosen

    def add(self, slot: int, descriptor: NDArray[np.int8], /) -> None:
        """Note that a patch with this descriptor is sent in a slot."""
        self._patches[slot] = descriptor.astype(np.float64)


def _costs(frames: Descriptors, images: Descriptors) -> NDArray[np.float64]:
    """Return the costs (N, M) of showing each frame (N, k) by each image (M, k)."""
    return np.asarray(np.linalg.norm(frames[:, None] - images, axis=2) ** COST_POWER)


class PatchScheduler:
    """Requests patches for one photo after the other, within a byte rate."""

    def __init__(self) -> None:
        self._sets: list[PatchSet] = []
        self._budget = TokenBucket(BYTES_PER_SECOND, BURST_BYTES)
        self._unfit: dict[tuple[int, int], RecentFrame] = {}  # by region and identity: the feature cannot be cut

    def set_photo(self, displacements: NDArray[np.floating]) -> None:
        """Start without patches on a photo that shows these displacements (n, 3), FAPU units."""
        self._sets = [PatchSet(feature.quantised_descriptor(displacements)) for feature in FEATURES]
        self._unfit.clear()

    def next_request(
        self,
        frames: Sequence[RecentFrame],
        now: float,
        /,
        *,
        waiting_bytes: int,
        can_patch: Callable[[RecentFrame, int], bool],
        below: Sequence[Descriptors] | None = None,
    ) -> tuple[int, int, RecentFrame] | None:
        """Return region, slot and frame of the next patch, None if none is worth its bytes or there are none.

        waiting_bytes : of all objects, not yet acknowledged
        can_patch : whether the feature of a region can be cut from a frame; costly, so it is called once at most
        below : of each region, (N, k) descriptors of what photo and views show in each frame; the photo's if None
        """
        if waiting_bytes > MAX_WAITING_BYTES or not frames:
            return None
        recent = {id(frame) for frame in frames}
        self._unfit = {key: frame for key, frame in self._unfit.items() if key[1] in recent}
        best: tuple[float, int, int, RecentFrame] | None = None
        for region, (patches, feature) in enumerate(zip(self._sets, FEATURES, strict=True)):
            if self._budget.time_until(PATCH_BYTES[feature.name], now) > 0:
                continue
            wanted = np.array([frame.descriptors[region] for frame in frames], np.float64)
            gains, slots = patches.gains(wanted, None if below is None else below[region])
            gains[[(region, id(frame)) in self._unfit for frame in frames]] = 0.0
            index = int(np.argmax(gains))
            if gains[index] > (best[0] if best else 0.0):
                best = float(gains[index]), region, int(slots[index]), frames[index]
        if best is None:
            return None
        _, region, slot, frame = best
        if not can_patch(frame, region):
            self._unfit[region, id(frame)] = frame
            return None
        self._budget.consume(PATCH_BYTES[FEATURES[region].name], now)
        self._sets[region].add(slot, frame.descriptors[region])
        return region, slot, frame


class RateSharing:
    """Delay patches while a view is being sent, so that it gets most of the rate although patches are sent first."""

    def __init__(self) -> None:
        self._left = 0  # bytes of the view not acknowledged when the last patch was requested

    def allows_patch(self, view_bytes: int) -> bool:
        """Return whether a patch may be requested. view_bytes : of views that are sent, not acknowledged yet"""
        self._left = max(self._left, view_bytes)
        return view_bytes == 0 or view_bytes <= self._left - VIEW_BYTES_PER_PATCH

    def on_patch(self, view_bytes: int) -> None:
        """Note that a patch was requested."""
        self._left = view_bytes
