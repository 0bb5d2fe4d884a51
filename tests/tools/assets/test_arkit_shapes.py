import numpy as np

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX, PUPILS
from tools.assets.arkit_shapes import FULL_GAZE, load_arkit_shapes


def test_there_are_52_shapes_of_all_control_points() -> None:
    shapes = load_arkit_shapes()
    assert len(shapes) == 52
    assert all(shape.shape == (CONTROL_POINT_COUNT, 3) and np.isfinite(shape).all() for shape in shapes.values())


def test_shapes_move_points_according_to_their_names() -> None:
    shapes = load_arkit_shapes()
    assert shapes["jawOpen"][CONTROL_POINT_INDEX["chin_bottom"], 1] < -500
    assert shapes["eyeBlinkLeft"][CONTROL_POINT_INDEX["eyelid_upper_l"], 1] < -1000
    assert shapes["mouthSmileRight"][CONTROL_POINT_INDEX["outer_lip_corner_r"], 0] < -50  # outwards
    assert shapes["browInnerUp"][CONTROL_POINT_INDEX["brow_inner_l"], 1] > 50


def test_a_gaze_shape_moves_one_pupil_in_its_direction() -> None:
    shapes = load_arkit_shapes()
    for direction, (x, y, _) in FULL_GAZE.items():
        left, right = shapes[f"eyeLook{direction}Left"][PUPILS, :2]
        np.testing.assert_array_equal(np.sign(left), [x, y])
        np.testing.assert_array_equal(right, 0)
    assert shapes["eyeLookInRight"][CONTROL_POINT_INDEX["pupil_r"], 0] > 0  # towards the nose
