from dataclasses import replace

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.head_pose import HeadPose
from conf.face.portrait.patch_features import DESCRIPTOR_STEP, FEATURES, MOUTH
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.view import MAX_VIEWS, View, decode_view, encode_view
from conf.protocol.portrait.vp8 import read_frame_size
from conf.sender.portrait.album import MIN_FRAMES, VIEW_BYTES, Album, ViewChoice, view_steps
from conf.sender.portrait.photo_builder import encode_vp8
from conf.sender.portrait.recent_frames import RecentFrame
from tests.support.drawn_person import make_view
from tests.support.portrait_subjects import motion, recent_frame, shaded_person, still
from tests.support.synthetic_portrait import POSE, face_shape

pytestmark = pytest.mark.slow


def frame(turn: float = 0.0) -> RecentFrame:
    pose = HeadPose(POSE.rotation + np.array([0.0, turn, 0.0]), POSE.position, POSE.log_scale)
    return recent_frame(shaded_person(), motion(still(), pose))


def frames_of(count: int, turn: float = 0.0) -> list[RecentFrame]:
    """Return different frames of one pose. All have the same pixels: turned ones show what no photo predicts."""
    return [frame(turn) for _ in range(count)]


def album() -> Album:
    return Album(PortraitWarp(face_shape()), shaded_person())


def choose(kept: Album, frames: list[RecentFrame]) -> ViewChoice | None:
    kept.describe(frames, limit=len(frames))
    return kept.choose()


def build(kept: Album, choice: ViewChoice, number: int = 7) -> View:
    *before, view = view_steps(choice, PortraitWarp(face_shape()), number)
    assert len(before) > 3 and set(before) == {None} and view is not None
    return view


def test_a_view_is_chosen_where_photo_and_views_often_show_the_face_wrong() -> None:
    chosen = choose(album(), [*frames_of(MIN_FRAMES), *frames_of(8, 0.3), *frames_of(4, -0.4)])
    assert chosen is not None and chosen.slot == 0
    np.testing.assert_allclose(chosen.medoid.pose.rotation, frame(0.3).pose.rotation)
    assert [each.pose.rotation[1] for each in chosen.cluster[:7]] == [chosen.medoid.pose.rotation[1]] * 7


def test_no_view_is_chosen_of_a_still_face_or_of_few_frames() -> None:
    assert choose(album(), frames_of(MIN_FRAMES - 1, 0.3)) is None
    assert choose(album(), [frame(0.001 * i) for i in range(MIN_FRAMES)]) is None


def test_frames_are_described_a_few_at_a_time_and_forgotten_when_they_are_old() -> None:
    kept, frames = album(), [*frames_of(4), *frames_of(MIN_FRAMES, 0.3)]
    kept.describe(frames)
    assert kept.choose() is None
    for _ in frames:
        kept.describe(frames)
    assert kept.choose() is not None
    kept.describe(frames[:3])
    assert kept.choose() is None


def test_covered_frames_are_neither_shown_nor_asked_for_twice() -> None:
    kept, free, covered = album(), frames_of(MIN_FRAMES), frames_of(10, 0.3)
    asked: list[RecentFrame] = []

    def is_covered(each: RecentFrame) -> bool:
        asked.append(each)
        return each in covered

    for _ in range(2):
        kept.describe([*free, *covered], is_covered=is_covered, limit=len(free) + len(covered))
    assert kept.choose() is None
    assert asked == [*free, *covered]


def test_a_view_that_shows_the_frames_no_better_is_not_sent() -> None:
    kept = album()
    choice = choose(kept, [*frames_of(MIN_FRAMES), *frames_of(10, 0.3)])
    assert choice is not None
    view = build(kept, choice)
    black = encode_vp8(np.zeros((*read_frame_size(view.frame)[::-1], 3), np.uint8), max_bytes=VIEW_BYTES)
    assert not kept.add(replace(view, frame=black)) and kept.shown_descriptors([frame()]) is None
    assert kept.add(view) and kept.shown_descriptors([frame()]) is not None


def test_when_all_slots_are_used_the_least_needed_view_is_replaced() -> None:
    kept = album()
    for slot, turn in enumerate((0.25, -0.3, 0.5)):
        choice = choose(kept, [*frames_of(MIN_FRAMES), *frames_of(10, turn)])
        assert choice is not None and choice.slot == slot < MAX_VIEWS and kept.add(build(kept, choice))
    choice = choose(kept, [*frames_of(10, 0.25), *frames_of(10, -0.3), *frames_of(10, -0.6)])
    assert choice is not None and choice.slot == MAX_VIEWS - 1
    np.testing.assert_allclose(choice.medoid.pose.rotation, frame(-0.6).pose.rotation)


def test_a_view_is_what_is_shown_in_frames_that_resemble_it() -> None:
    kept, neutral, opened = album(), recent_frame(), still()
    assert kept.shown_descriptors([neutral]) is None
    opened[CONTROL_POINT_INDEX["inner_lip_lower_mid"], 1] = -700
    points = PortraitWarp(face_shape()).control_points(opened)
    assert kept.add(replace(make_view(), points=points))
    shown = kept.shown_descriptors([neutral, recent_frame(moved=motion(opened))])
    assert shown is not None
    expected = np.array([MOUTH.descriptor(still()), MOUTH.descriptor(opened)]) / DESCRIPTOR_STEP
    np.testing.assert_allclose(shown[FEATURES.index(MOUTH)], expected, atol=1)


def test_a_view_is_built_in_steps_and_cropped_to_the_face() -> None:
    kept = album()
    choice = choose(kept, [*frames_of(MIN_FRAMES), *frames_of(6, 0.2)])
    assert choice is not None
    view = build(kept, choice)
    assert (view.photo_number, view.slot) == (7, 0) and len(view.frame) <= VIEW_BYTES
    width, height = read_frame_size(view.frame)
    left, top, right, bottom = view.box
    assert width == pytest.approx((right - left) * 320, abs=1) and height == pytest.approx((bottom - top) * 240, abs=1)
    assert 0 < width < 320 and decode_view(encode_view(view)).box == view.box
