import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.head_pose import HeadPose
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.view import MAX_VIEWS, decode_view, encode_view
from conf.protocol.portrait.vp8 import read_frame_size
from conf.sender.portrait.album import MIN_FRAMES, VIEW_BYTES, Album, distances, frame_shapes, view_steps
from conf.sender.portrait.recent_frames import RecentFrame
from tests.support.portrait_subjects import motion, shaded_person, still
from tests.support.synthetic_portrait import POSE, face_shape

pytestmark = pytest.mark.slow

OPEN = still()
OPEN[[CONTROL_POINT_INDEX[f"inner_lip_lower_{at}"] for at in ("mid", "l", "r")], 1] = -700


def frame(turn: float = 0.0, *, is_open: bool = False) -> RecentFrame:
    pose = HeadPose(POSE.rotation + np.array([0.0, turn, 0.0]), POSE.position, POSE.log_scale)
    return RecentFrame(shaded_person(), motion(OPEN if is_open else still(), pose), 0.0)


def album() -> Album:
    warp = PortraitWarp(face_shape())
    return Album(warp, frame_shapes(warp, [frame()]))


def test_a_view_is_chosen_where_the_face_is_often_far_from_the_photo() -> None:
    frames = [frame()] * MIN_FRAMES + [frame(0.3)] * 8 + [frame(-0.4)] * 4
    chosen = album().choose(frames)
    assert chosen is not None and chosen.slot == 0
    np.testing.assert_allclose(chosen.medoid.pose.rotation, frame(0.3).pose.rotation)
    assert len(chosen.cluster) == 7


def test_no_view_is_chosen_of_a_still_face_or_of_few_frames() -> None:
    assert album().choose([frame(0.3)] * (MIN_FRAMES - 1)) is None
    assert album().choose([frame(0.001 * i) for i in range(MIN_FRAMES)]) is None


def test_when_all_slots_are_used_the_least_needed_view_is_replaced() -> None:
    kept = album()
    for turn in (0.25, -0.3, 0.5):
        choice = kept.choose([frame()] * MIN_FRAMES + [frame(turn)] * 10)
        assert choice is not None
        kept.add(choice)
    assert kept.slots == list(range(MAX_VIEWS))
    frames = [frame(0.25)] * 10 + [frame(-0.3)] * 10 + [frame(is_open=True)] * 10
    choice = kept.choose(frames)
    assert choice is not None and choice.slot == MAX_VIEWS - 1 and np.any(choice.medoid.motion.displacements)


def test_a_view_is_built_in_steps_and_cropped_to_the_face() -> None:
    warp = PortraitWarp(face_shape())
    choice = Album(warp, frame_shapes(warp, [frame()])).choose([frame()] * MIN_FRAMES + [frame(0.2)] * 6)
    assert choice is not None
    *before, view = view_steps(choice, warp, 7)
    assert len(before) > 3 and set(before) == {None} and view is not None
    assert (view.photo_number, view.slot) == (7, 0) and len(view.frame) <= VIEW_BYTES
    width, height = read_frame_size(view.frame)
    left, top, right, bottom = view.box
    assert width == pytest.approx((right - left) * 320, abs=1) and height == pytest.approx((bottom - top) * 240, abs=1)
    assert 0 < width < 320 and decode_view(encode_view(view)).box == view.box


def test_distances_are_those_of_all_pairs() -> None:
    a, b = np.random.default_rng(1).normal(size=(2, 5, 6))
    np.testing.assert_allclose(distances(a, b), np.linalg.norm(a[:, None] - b, axis=2), atol=1e-9)
