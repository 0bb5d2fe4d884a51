from pathlib import Path

import numpy as np
import pytest

from conf.face.animation.action_units import load_action_units
from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.fapu import Fapu
from conf.face.formats.dpc import MotionClip
from conf.face.retargeting.mpeg4_fap import FAP_COUNT, FapMotion, to_faps, write_fap

FAPU = Fapu(es0=6.4, ens0=4.8, mns0=2.6, mw0=5.1, irisd0=0.97)


def motion(*displacements: np.ndarray, poses: np.ndarray | None = None) -> MotionClip:
    return MotionClip(25.0, "fapu", np.stack(displacements).astype(np.float32), poses)


def faps_of_point(point: str, axis: int, value: float) -> FapMotion:
    displacements = np.zeros((CONTROL_POINT_COUNT, 3))
    displacements[CONTROL_POINT_INDEX[point], axis] = value
    return to_faps(motion(displacements), FAPU)


@pytest.mark.parametrize(
    ("point", "axis", "value", "fap", "expected"),
    [
        ("chin_bottom", 1, -500.0, 3, 500),  # open_jaw, downwards
        ("chin_bottom", 2, 100.0, 14, round(100 * 5.1 / 2.6)),  # thrust_jaw: our depth unit is the mouth width
        ("chin_bottom", 0, -50.0, 15, 50),  # shift_jaw, to the right
        ("inner_lip_corner_r", 0, -80.0, 7, 80),  # stretch_r_cornerlip, outwards
        ("eyelid_upper_l", 1, -1024.0, 19, 1024),  # close_t_l_eyelid
        ("eyelid_lower_r", 1, 60.0, 22, 60),  # close_b_r_eyelid, upwards
        ("brow_inner_l", 1, 120.0, 31, 120),
        ("brow_inner_l", 0, -64.0, 37, 48),  # squeeze_l_eyebrow, in eye distances
        ("outer_lip_corner_l", 1, 300.0, 59, 300),
        ("nostril_border_r", 0, -20.0, 62, 20),
    ],
)
def test_parameters_have_the_right_point_direction_and_unit(
    point: str, axis: int, value: float, fap: int, expected: int
) -> None:
    faps = faps_of_point(point, axis, value)
    assert faps.values[0, fap - 1] == expected
    assert np.count_nonzero(faps.values) == 1
    assert faps.used[fap - 1]


def test_gaze_and_head_are_angles() -> None:
    displacements = np.zeros((CONTROL_POINT_COUNT, 3))
    displacements[CONTROL_POINT_INDEX["pupil_l"], :2] = 192 * np.sin([0.2, 0.1])
    pose = np.array([0.1, 0.0, 0.0, 0.3, 0.0, -3.0])  # nodding: the pitch of a FAP is positive downwards
    values = to_faps(motion(displacements, poses=pose[None]), FAPU).values[0]
    np.testing.assert_allclose(values[[22, 23, 24, 25]], [20000, 0, -10000, 0], atol=1)
    np.testing.assert_allclose(values[[47, 48, 49]], [10000, 0, 0], atol=1)


def test_without_a_pose_head_parameters_are_unused() -> None:
    assert not faps_of_point("chin_bottom", 1, 1.0).used[47:50].any()
    assert not faps_of_point("chin_bottom", 1, 1.0).used[:2].any()


def test_a_motion_in_mesh_units_is_an_error() -> None:
    with pytest.raises(ValueError, match="FAPU units"):
        to_faps(MotionClip(25.0, "mesh", np.zeros((1, CONTROL_POINT_COUNT, 3), np.float32)), FAPU)


@pytest.mark.parametrize("count", [1, 3])
def test_the_file_has_the_values_of_the_used_parameters(tmp_path: Path, count: int) -> None:
    rng = np.random.default_rng(count)
    values, used = rng.integers(-99999, 99999, (count, FAP_COUNT), dtype=np.int32), rng.random(FAP_COUNT) < 0.5
    write_fap(tmp_path / "a.fap", FapMotion(29.97, values, used))
    header, *lines = (tmp_path / "a.fap").read_text().splitlines()
    assert header == f"2.1 conf 30 {count}"
    for i, (mask, line) in enumerate(zip(lines[::2], lines[1::2], strict=True)):
        np.testing.assert_array_equal(np.array(mask.split()) == "1", used)
        assert [int(word) for word in line.split()] == [i, *values[i, used].tolist()]


def test_a_motion_without_frames_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"values must have shape \(frames, 68\), got \(0, 68\)"):
        write_fap(
            tmp_path / "a.fap", FapMotion(25.0, np.zeros((0, FAP_COUNT), np.int32), np.zeros(FAP_COUNT, np.bool_))
        )


def test_the_file_of_an_action_unit(tmp_path: Path) -> None:
    write_fap(tmp_path / "a.fap", to_faps(motion(*[load_action_units()[26]] * 2), FAPU))
    header, mask, first, _, second = (tmp_path / "a.fap").read_text().splitlines()
    assert header == "2.1 conf 25 2"
    assert len(mask.split()) == FAP_COUNT
    assert first.split()[0] == "0" and second.split()[0] == "1"
    assert len(first.split()) == 1 + mask.split().count("1")
    assert int(first.split()[1]) > 400  # the jaw is open
