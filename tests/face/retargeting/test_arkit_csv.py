import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from conf.face.animation.gaze import gaze_displacements
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.formats.dpc import MotionClip
from conf.face.retargeting.arkit_csv import HEADER, OPPOSITES, SHAPES, arkit_weights, timecode, write_blendshape_csv
from conf.face.symmetry import mirror_motion
from tools.assets.arkit_shapes import load_arkit_shapes


def sculpted(*names: str) -> np.ndarray:
    return np.sum([load_arkit_shapes()[name] for name in names], axis=0)[None]


def weights_of(displacements: np.ndarray) -> dict[str, float]:
    return dict(zip(SHAPES, arkit_weights(displacements)[0].tolist(), strict=True))


@pytest.mark.parametrize("name", sorted(set(SHAPES) - {"tongueOut", "cheekPuff"}))
def test_a_sculpted_shape_has_more_of_its_own_weight_than_of_any_other(name: str) -> None:
    weights = weights_of(sculpted(name))
    assert max(weights, key=weights.__getitem__) == name
    assert weights[name] > 0.4


def test_a_face_at_rest_has_hardly_any_weight() -> None:
    assert arkit_weights(np.zeros((1, CONTROL_POINT_COUNT, 3))).max() < 0.1


def test_a_mixture_has_its_weights() -> None:
    weights = weights_of(sculpted("eyeBlinkRight", "mouthSmileLeft", "jawOpen"))
    assert weights["eyeBlinkRight"] > 0.75 and weights["eyeBlinkLeft"] < 0.15
    assert weights["mouthSmileLeft"] > 0.5 and weights["mouthSmileRight"] < 0.3
    assert weights["jawOpen"] > 0.5


@given(hnp.arrays(np.float64, (3, CONTROL_POINT_COUNT, 3), elements=st.floats(-3000, 3000, width=32)))
def test_of_opposites_one_is_zero_and_all_are_between_0_and_1(displacements: np.ndarray) -> None:
    weights = arkit_weights(displacements)
    assert weights.shape == (3, 52)
    assert (weights >= 0).all() and (weights <= 1).all()
    for first, second in OPPOSITES:
        assert (np.minimum(weights[:, SHAPES.index(first)], weights[:, SHAPES.index(second)]) <= 1e-3).all()


def test_a_mirrored_motion_has_mirrored_weights() -> None:
    motion = sculpted("mouthSmileLeft", "browDownRight", "jawLeft")
    weights, mirrored = weights_of(motion), weights_of(mirror_motion(motion[0])[None])
    for name, weight in weights.items():
        other = name.replace("Left", "-").replace("Right", "Left").replace("-", "Right")
        assert mirrored[other] == pytest.approx(weight, abs=0.01)


def test_given_weights_are_written_as_they_are(tmp_path: Path) -> None:
    weights = np.linspace(0, 1, 52)[None]
    motion = MotionClip(30.0, "fapu", np.zeros((1, CONTROL_POINT_COUNT, 3), np.float32))
    write_blendshape_csv(tmp_path / "a.csv", motion, weights=weights)
    _, row = csv.reader((tmp_path / "a.csv").read_text().splitlines())
    np.testing.assert_allclose([float(value) for value in row[2:54]], weights[0], atol=1e-6)


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
