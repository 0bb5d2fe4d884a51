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
    PATCH_MEMORY,
    VIEW_BYTES_PER_PATCH,
    PatchScheduler,
    PatchSet,
    RateSharing,
)
from conf.sender.portrait.recent_frames import RecentFrame
from tests.support.portrait_subjects import motion, recent_frame, shaded_person, still

INNER_LOWER_LIP = [CONTROL_POINT_INDEX[f"inner_lip_lower_{at}"] for at in ("mid", "l", "r")]
MOUTH_REGION, EYES_REGION = FEATURES.index(MOUTH), FEATURES.index(EYES)


def face(mouth: float = 0.0, lids: float = 0.0) -> NDArray[np.float64]:
    """Return displacements with the mouth opened and the upper lids lowered by so many FAPU units."""
    displacements = still()
    displacements[INNER_LOWER_LIP, 1] = -mouth
    displacements[UPPER, 1] = -lids
    return displacements


def recent(*faces: tuple[float, float]) -> list[RecentFrame]:
    """Return frames (mouth, lids), oldest first."""
    pixels = shaded_person()
    return [recent_frame(pixels, motion(face(mouth, lids))) for mouth, lids in faces]


def requests(
    faces: list[tuple[float, float]], *, waiting_bytes: int = 0, can_patch: bool = True
) -> list[tuple[int, int]]:
    """Return (region, slot) of the patches asked for while one frame after the other (mouth, lids) arrives."""
    scheduler = PatchScheduler()
    scheduler.set_photo(face())
    frames = recent(*faces)
    found = []
    for i in range(len(frames)):
        request = scheduler.next_request(
            frames[: i + 1], i / 15, waiting_bytes=waiting_bytes, can_patch=lambda _, __: can_patch
        )
        if request is not None:
            region, slot, frame = request
            assert frame in frames[: i + 1]
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
    size, frames = PATCH_BYTES[MOUTH.name], recent((700, 0))

    def ask(now: float) -> bool:
        scheduler.set_photo(face())
        return scheduler.next_request(frames, now, waiting_bytes=0, can_patch=lambda _, __: True) is not None

    assert [ask(0.0) for _ in range(BURST_BYTES // size + 1)] == [True] * (BURST_BYTES // size) + [False]
    refilled = (size - BURST_BYTES % size) / BYTES_PER_SECOND
    assert not ask(refilled - 0.01)
    assert ask(refilled + 0.01)


def test_the_gain_is_the_cost_saved_over_all_frames() -> None:
    patches = PatchSet(descriptor(0, 0))
    frames = np.array([[20.0, 0.0], [20.0, 0.0], [0.0, 30.0], [3.0, 4.0]])
    gains, slots = patches.gains(frames)
    assert gains[:3] == pytest.approx([2 * 20**0.5, 2 * 20**0.5, 30**0.5])
    assert gains[3] == 0 and set(slots) == {0}  # 5 steps from the photo: not worth a patch
    patches.add(0, descriptor(20, 0))
    gains, slots = patches.gains(frames)
    assert gains == pytest.approx([0.0, 0.0, 30**0.5, 0.0]) and set(slots) == {1}


def test_a_patch_replaces_the_one_whose_loss_costs_least() -> None:
    patches = PatchSet(descriptor(0, 0), slots=3)
    for slot, values in enumerate(((30, 0), (0, 30), (1, 30))):
        patches.add(slot, descriptor(*values))
    gains, slots = patches.gains(np.array([[-30.0, 0.0], [2.0, 29.0]]))
    assert slots[0] == 1 and gains[0] == pytest.approx(30**0.5 - PATCH_MEMORY)
    assert gains[1] == 0


def test_a_rare_expression_does_not_replace_patches_that_are_all_needed() -> None:
    patches = PatchSet(descriptor(0, 0), slots=2)
    patches.add(0, descriptor(30, 0))
    patches.add(1, descriptor(0, 30))
    gains, _ = patches.gains(np.array([[-30.0, 0.0]]))
    assert gains[0] <= 0


def test_a_frame_whose_feature_is_covered_is_asked_for_once() -> None:
    scheduler, frames = PatchScheduler(), recent((700, 0))
    scheduler.set_photo(face())
    asked = []

    def covered(frame: RecentFrame, region: int) -> bool:
        asked.append((frame, region))
        return False

    for i in range(3):
        assert scheduler.next_request(frames, i / 15, waiting_bytes=0, can_patch=covered) is None
    assert asked == [(frames[0], MOUTH_REGION)]


def test_an_expression_gets_its_patch_when_there_are_bytes_for_it() -> None:
    scheduler, frames = PatchScheduler(), recent((700, 0), (0, 0), (0, 0))
    scheduler.set_photo(face())
    assert scheduler.next_request(frames, 0, waiting_bytes=MAX_WAITING_BYTES + 1, can_patch=lambda _, __: True) is None
    request = scheduler.next_request(frames, 1, waiting_bytes=0, can_patch=lambda _, __: True)
    assert request == (MOUTH_REGION, 0, frames[0])


def descriptor(*values: int) -> NDArray[np.int8]:
    return np.array(values, np.int8)


def test_a_view_has_most_of_the_rate_while_it_is_sent() -> None:
    sharing = RateSharing()
    assert sharing.allows_patch(0)
    sharing.on_patch(0)
    requested = []
    for left in range(1200, -1, -100):
        if sharing.allows_patch(left):
            sharing.on_patch(left)
            requested.append(left)
    assert requested == [*range(1200 - VIEW_BYTES_PER_PATCH, -1, -VIEW_BYTES_PER_PATCH)]
    assert not sharing.allows_patch(900), "another view"


def test_what_a_view_shows_gets_no_patch() -> None:
    patches = PatchSet(MOUTH.quantised_descriptor(face()))
    opened = MOUTH.quantised_descriptor(face(700))[None].astype(float)
    assert patches.gains(opened)[0] > 0
    assert patches.gains(opened, opened)[0] == 0
