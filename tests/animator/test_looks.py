"""Look, influence, layout, muscling: small pure parts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.animator.influence import STILL, point_colours, region_colours
from conf.animator.layout import Layout, scale_of
from conf.animator.look import with_eye_contact
from conf.animator.muscling import MUSCLES, POSES, Muscling, sides_of
from conf.animator.player import REST_POSE
from conf.face.control_points import INDEX
from conf.face.face_muscles import MUSCLE_NAMES
from conf.face.gaze import gaze_angles, gaze_displacements
from conf.face.head import FaceModel
from conf.receiver.scene import View

angles = st.floats(-0.4, 0.4)


@given(angles, angles)
def test_eyes_in_contact_look_back_along_the_line_of_sight(yaw: float, pitch: float) -> None:
    view = View(yaw=yaw, pitch=pitch)
    straying = gaze_displacements(0.2, -0.1)
    left, right = gaze_angles(with_eye_contact(straying, REST_POSE, view))
    np.testing.assert_allclose(left, right, atol=1e-6)
    assert left[0] == pytest.approx(-yaw, abs=0.06)
    assert np.sign(left[1]) == -np.sign(pitch) or abs(pitch) < 0.05


def test_eyes_do_not_roll_after_a_viewer_behind_the_head() -> None:
    eyes = gaze_angles(with_eye_contact(np.zeros((50, 3), np.float32), REST_POSE, View(yaw=2.0)))
    np.testing.assert_allclose(eyes, 0.0, atol=1e-6)


def test_regions_are_coloured_where_something_moves(head: FaceModel) -> None:
    colours = region_colours(head.operator)
    assert colours.shape == (len(head.neutral), 3) and colours.min() >= 0 and colours.max() <= 1
    crown = head.neutral[:, 1].argmax()
    np.testing.assert_allclose(colours[crown], np.array(STILL) / 255, atol=0.12)
    at = [np.linalg.norm(head.neutral - head.control_points[INDEX[name]], axis=1).argmin()
          for name in ("outer_lip_upper_mid", "outer_lip_lower_mid", "brow_top_l")]  # fmt: skip
    upper, lower, brow = colours[at]
    assert min(np.abs(upper - lower).max(), np.abs(upper - brow).max(), np.abs(lower - brow).max()) > 0.15


def test_one_points_influence_is_hottest_at_the_point(head: FaceModel) -> None:
    point = INDEX["brow_top_l"]
    heat = point_colours(head.operator, point)[:, 0]
    hottest = head.neutral[heat.argmax()]
    assert np.linalg.norm(hottest - head.control_points[point]) < 1.5


@given(st.integers(320, 4000), st.integers(240, 3000), st.sampled_from([1.0, 2.0]))
def test_the_windows_parts_cover_it_and_do_not_overlap(width: int, height: int, ratio: float) -> None:
    layout = Layout.of((width, height), scale_of((width, height), ratio))
    assert layout.left.width + layout.face.width + layout.right.width == width
    assert layout.face.width == layout.timeline.width and layout.face.width >= width / 4
    x, y, w, h = layout.face_viewport(height)
    assert x >= 0 and y >= 0 and w > 0 and h > 0 and x + w <= width and y + h <= height


def test_muscles_contract_on_both_sides_or_one() -> None:
    both = Muscling().contract("corrugator_l", 0.3)
    assert both.contractions == {"corrugator_l": 0.3, "corrugator_r": 0.3}
    assert Muscling(both=False).contract("corrugator_r", 0.3).contractions == {"corrugator_r": 0.3}
    assert Muscling().contract("orbicularis_oris", 0.3).contractions == {"orbicularis_oris": 0.3}
    assert sorted(name for stem in MUSCLES for name in sides_of(stem)) == sorted(MUSCLE_NAMES)


def test_every_pose_is_of_muscles_that_are_there() -> None:
    for pose in POSES:
        assert set(Muscling().posed(pose).contractions) <= set(MUSCLE_NAMES)
        assert Muscling().posed(pose).active
