import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.optimize import lsq_linear

from conf.face.animation.gaze import gaze_displacements
from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX, PUPILS
from conf.face.formats.dpc import MotionClip
from conf.face.loading import load_face
from conf.face.retargeting.arkit_csv import (
    FULL_GAZE,
    HEADER,
    SHAPES,
    bounded_least_squares,
    load_arkit_shapes,
    solve_arkit_weights,
    timecode,
    write_blendshape_csv,
)

matrices = hnp.arrays(np.float64, (4, 7), elements=st.floats(-2, 2, width=16))
targets = hnp.arrays(np.float64, (3, 7), elements=st.floats(-5, 5, width=16))


def all_shapes() -> np.ndarray:
    return np.stack([load_arkit_shapes()[name] for name in SHAPES])


@pytest.mark.slow
def test_every_sculpted_shape_has_weight_1_of_itself() -> None:
    shapes = all_shapes()
    weights = solve_arkit_weights(shapes)
    moving = np.abs(shapes).max(axis=(1, 2)) > 0  # the tongue has no control point
    assert moving.sum() == 51
    np.testing.assert_allclose(weights[moving], np.eye(52)[moving], atol=0.04)
    rebuilt = np.einsum("ns,spi->npi", weights, shapes)
    assert np.abs((rebuilt - shapes) * load_face().fapu.lengths()).max() < 0.02  # centimetres


@pytest.mark.slow
def test_a_mixture_has_its_weights() -> None:
    mixed = np.zeros(52)
    for name, weight in {"jawOpen": 0.6, "mouthSmileLeft": 0.8, "browInnerUp": 0.3, "eyeBlinkRight": 1.0}.items():
        mixed[SHAPES.index(name)] = weight
    weights = solve_arkit_weights(np.einsum("s,spi->pi", mixed, all_shapes())[None])[0]
    np.testing.assert_allclose(weights, mixed, atol=0.04)


@pytest.mark.slow
@given(factor=st.floats(-3, 3), shape=st.integers(0, 51))
def test_weights_are_between_0_and_1_for_any_motion(factor: float, shape: int) -> None:
    weights = solve_arkit_weights(factor * all_shapes()[shape][None])
    assert weights.shape == (1, 52)
    assert (weights >= 0).all() and (weights <= 1).all()


@pytest.mark.slow
@given(basis=matrices, target_rows=targets)
def test_the_solution_is_as_good_as_scipys(basis: np.ndarray, target_rows: np.ndarray) -> None:
    solved = bounded_least_squares(basis, target_rows, regularisation=0.01)
    rows = np.vstack([basis.T, 0.1 * np.eye(4)])
    for weights, target in zip(solved, target_rows, strict=True):
        right_side = np.append(target, np.zeros(4))
        expected = lsq_linear(rows, right_side, (0, 1)).x
        assert (weights >= 0).all() and (weights <= 1).all()
        assert np.linalg.norm(rows @ weights - right_side) <= np.linalg.norm(rows @ expected - right_side) + 1e-9


def test_the_table_has_the_columns_of_live_link_face(tmp_path: Path) -> None:
    displacements = np.stack([gaze_displacements(0.0, 0.0), gaze_displacements(0.3, 0.0)])
    poses = np.array([[0, 0.5, 0, 0, 0, -3.0]] * 2)
    write_blendshape_csv(tmp_path / "a.csv", MotionClip(30.0, "fapu", displacements, poses))
    header, first, second = csv.reader((tmp_path / "a.csv").read_text().splitlines())
    assert tuple(header) == HEADER
    assert len(HEADER) == 63 and HEADER[2] == "EyeBlinkLeft" and HEADER[53] == "TongueOut"
    assert first[:2] == ["00:00:00:00.000", "61"] and second[0] == "00:00:00:01.000"
    row = dict(zip(header[2:], map(float, second[2:]), strict=True))
    assert row["HeadYaw"] == pytest.approx(0.5, abs=1e-5)
    assert row["LeftEyeYaw"] == row["RightEyeYaw"] == pytest.approx(0.3, abs=1e-4)
    assert row["EyeLookOutLeft"] > 0.5 and row["EyeLookInRight"] > 0.5


def test_a_motion_in_mesh_units_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="FAPU units"):
        write_blendshape_csv(
            tmp_path / "a.csv", MotionClip(15.0, "mesh", np.zeros((1, CONTROL_POINT_COUNT, 3), np.float32))
        )


@pytest.mark.parametrize(
    ("frame", "fps", "text"),
    [(0, 15.0, "00:00:00:00.000"), (15 * 3661 + 7, 15.0, "01:01:01:07.000"), (1, 29.97, "00:00:00:01.001")],
)
def test_timecode_of_a_frame(frame: int, fps: float, text: str) -> None:
    assert timecode(frame, fps) == text


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
