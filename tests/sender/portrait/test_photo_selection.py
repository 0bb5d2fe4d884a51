from dataclasses import replace

import pytest

from conf.protocol.messages import MotionFrame
from conf.sender.motion.eye_openness import UPPER
from conf.sender.portrait.photo_selection import PhotoSelector
from tests.support.portrait_subjects import captured_face, motion, still

FPS = 10
FACE = captured_face()


def motion_of(*, eyes_shut: bool) -> MotionFrame:
    displacements = still()
    displacements[UPPER, 1] = -1000 if eyes_shut else 0
    return motion(displacements)


def photo_times(
    steps: list[tuple[float, float, bool]], seconds: float, scene_change: float | None, *, delivered: bool = True
) -> list[float]:
    """Return when photos are due. steps : (from time, image penalty, eyes shut)."""
    selector, times = PhotoSelector(), list[float]()
    for i in range(round(seconds * FPS) + 1):
        now = i / FPS
        _, penalty, eyes_shut = [step for step in steps if step[0] <= now][-1]
        selector.set_scene_changed(now, changed=scene_change is not None and now >= scene_change and len(times) < 3)
        selector.add_frame(FACE, motion_of(eyes_shut=eyes_shut), penalty, now)
        if best := selector.pop_due(now, delivered=delivered):
            times.append(now)
            selector.set_photo(best, now)
    return times


GOOD, SHUT = (0.0, 0.0, False), (0.0, 0.0, True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("steps", "scene_change", "expected"),
    [
        ([GOOD], None, [0.0, 0.6]),
        ([SHUT], None, [0.3, 3.3]),
        ([SHUT, (2.0, 0.0, False)], None, [0.3, 2.5]),
        ([GOOD, (5.0, -0.9, False)], None, [0.0, 0.6]),
        ([GOOD, (5.0, -1.0, False)], None, [0.0, 0.6, 120.6]),
        ([GOOD, (5.0, -2.0, False)], None, [0.0, 0.6, 60.6]),
        ([GOOD, (50.0, -3.0, False)], None, [0.0, 0.6, 50.5]),
        ([GOOD], 5.0, [0.0, 0.6, 15.6]),
        ([GOOD, (20.0, 0.25, False)], 20.0, [0.0, 0.6, 21.5]),
        ([GOOD, (20.0, 1.0, False)], 20.0, [0.0, 0.6, 25.0]),
    ],
    ids=[
        "a good first frame is the draft, the full photo follows",
        "a draft with shut eyes is sent after 0.3 s and replaced after 3 s",
        "a draft with shut eyes is replaced by the first good frame",
        "a slightly better frame is not sent",
        "a better frame is sent after 120 s",
        "a much better frame is sent after half the time",
        "a frame must stay the best for 0.5 s",
        "after a scene change, 15 s after the photo before",
        "after a scene change, at the end of the search",
        "after a scene change, the worse the later",
    ],
)
def test_when_photos_are_due(
    steps: list[tuple[float, float, bool]], scene_change: float | None, expected: list[float]
) -> None:
    assert photo_times(steps, 130.0, scene_change) == pytest.approx(expected, abs=1e-9)


def test_no_photo_is_due_until_the_draft_is_delivered() -> None:
    assert photo_times([GOOD], 20.0, None, delivered=False) == [0.0]


def test_a_worse_frame_does_not_replace_a_draft_at_once() -> None:
    assert photo_times([GOOD, (0.1, 1.0, False)], 20.0, None) == pytest.approx([0.0, 5.0])


@pytest.mark.slow
def test_a_short_scene_change_gives_no_photo() -> None:
    selector = PhotoSelector()
    for i in range(600):
        selector.set_scene_changed(i / FPS, changed=i % 20 > 10)
        selector.add_frame(FACE, motion(), 0.0, i / FPS)
        if best := selector.pop_due(i / FPS, delivered=True):
            selector.set_photo(best, i / FPS)
            assert i <= 6


def test_a_moving_head_is_not_selected() -> None:
    selector = PhotoSelector()
    shift = still()
    for i in range(5):
        shift = shift + 200.0 * (i in (1, 2))
        frame = motion(shift)
        selector.add_frame(FACE, replace(frame, timestamp=i / 30), 0.0, i / 30)
    best = selector.pop_due(1.0, delivered=True)
    assert best is not None and best.time == 0.0
