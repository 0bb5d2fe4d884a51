import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.portrait.patch_features import EYES, FEATURES, MOUTH
from conf.sender.motion.eye_openness import UPPER
from conf.sender.portrait.patch_scheduler import (
    BURST_BYTES,
    BYTES_PER_SECOND,
    MAX_WAITING_BYTES,
    PATCH_BYTES,
    PatchScheduler,
    PatchSet,
)
from tests.support.portrait_subjects import still

INNER_LOWER_LIP = [CONTROL_POINT_INDEX[f"inner_lip_lower_{at}"] for at in ("mid", "l", "r")]
MOUTH_REGION, EYES_REGION = FEATURES.index(MOUTH), FEATURES.index(EYES)


def face(mouth: float = 0.0, lids: float = 0.0) -> NDArray[np.float64]:
    """Return displacements with the mouth opened and the upper lids lowered by so many FAPU units."""
    displacements = still()
    displacements[INNER_LOWER_LIP, 1] = -mouth
    displacements[UPPER, 1] = -lids
    return displacements


def requests(
    frames: list[tuple[float, float]], *, waiting_bytes: int = 0, can_patch: bool = True
) -> list[tuple[int, int]]:
    """Return (region, slot) for each frame (mouth, lids) that gets a patch."""
    scheduler = PatchScheduler()
    scheduler.set_photo(face())
    found = []
    for i, (mouth, lids) in enumerate(frames):
        request = scheduler.next_request(
            face(mouth, lids), i / 15, waiting_bytes=waiting_bytes, can_patch=lambda _: can_patch
        )
        if request is not None:
            region, slot, descriptor = request
            assert (descriptor == FEATURES[region].quantised_descriptor(face(mouth, lids))).all()
            found.append((region, slot))
    return found


@pytest.mark.parametrize(
    ("frames", "expected"),
    [
        ([(0, 0)] * 3, []),
        ([(60, 0)], []),  # two descriptors of 60/16 = 4 steps each: 5.7 of 6
        ([(80, 0)], [(MOUTH_REGION, 0)]),  # 5 steps each: 7.1
        ([(700, 0), (0, 0), (700, 0)], [(MOUTH_REGION, 0)]),
        ([(300, 0), (700, 0)], [(MOUTH_REGION, 0), (MOUTH_REGION, 1)]),
        ([(0, 1000)], [(EYES_REGION, 0)]),
        ([(100, 1000), (100, 1000)], [(EYES_REGION, 0), (MOUTH_REGION, 0)]),
    ],
    ids=[
        "as in the photo",
        "nearly as in the photo",
        "just different enough",
        "the same again",
        "two mouth shapes",
        "shut eyes",
        "the most novel feature comes first",
    ],
)
def test_which_frames_get_a_patch(frames: list[tuple[float, float]], expected: list[tuple[int, int]]) -> None:
    assert requests(frames) == expected


@pytest.mark.parametrize(
    ("waiting_bytes", "can_patch", "count"),
    [(MAX_WAITING_BYTES, True, 1), (MAX_WAITING_BYTES + 1, True, 0), (0, False, 0)],
)
def test_no_patch_while_bytes_wait_or_the_feature_cannot_be_cut(
    waiting_bytes: int, can_patch: bool, count: int
) -> None:
    assert len(requests([(700, 0)], waiting_bytes=waiting_bytes, can_patch=can_patch)) == count


def test_patches_keep_to_the_byte_rate_and_a_new_photo_starts_without_patches() -> None:
    scheduler = PatchScheduler()
    size = PATCH_BYTES[MOUTH.name]

    def ask(now: float) -> bool:
        scheduler.set_photo(face())
        return scheduler.next_request(face(700), now, waiting_bytes=0, can_patch=lambda _: True) is not None

    assert [ask(0.0) for _ in range(BURST_BYTES // size + 1)] == [True] * (BURST_BYTES // size) + [False]
    refilled = (size - BURST_BYTES % size) / BYTES_PER_SECOND
    assert not ask(refilled - 0.01)
    assert ask(refilled + 0.01)


def descriptor(*values: int) -> NDArray[np.int8]:
    return np.array(values, np.int8)


def test_novelty_is_the_distance_from_the_nearest_image() -> None:
    patches = PatchSet(descriptor(0, 0))
    assert patches.novelty(descriptor(3, 4)) == pytest.approx(5)
    assert patches.novelty(descriptor(30, 0)) == pytest.approx(30)
    assert patches.assign_slot(descriptor(30, 0)) == 0
    assert patches.novelty(descriptor(30, 0)) == 0


def test_the_most_redundant_patch_is_replaced() -> None:
    patches = PatchSet(descriptor(0, 0), slots=3)
    slots = [patches.assign_slot(descriptor(*values)) for values in ((50, 0), (0, 50), (4, 50))]
    assert slots == [0, 1, 2]
    assert patches.assign_slot(descriptor(-50, 0)) in (1, 2)
