from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from conf.errors import FileFormatError
from conf.face.animation.action_units import load_action_units
from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.fapu import Fapu
from conf.face.formats.dpc import MotionClip
from conf.face.retargeting.mpeg4_fap import FAP_COUNT, FapMotion, read_fap, to_faps, write_fap

FAPU = Fapu(es0=6.4, ens0=4.8, mns0=2.6, mw0=5.1, irisd0=0.97)
NO_MASK = " ".join("0" * FAP_COUNT)
GRETA = f"2.1 1-Welcome_1.fap 25 1\n1 {' '.join('0' * 67)} \n0 7 0 0 1 \n"
same_folder = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


def motion(*displacements: np.ndarray, poses: np.ndarray | None = None) -> MotionClip:
    return MotionClip(25.0, "fapu", np.stack(displacements).astype(np.float32), poses)


def one(point: str, axis: int, value: float) -> FapMotion:
    displacements = np.zeros((CONTROL_POINT_COUNT, 3))
    displacements[CONTROL_POINT_INDEX[point], axis] = value
    return to_faps(motion(displacements), FAPU)


@pytest.mark.parametrize(
    ("point", "axis", "value", "fap", "expected"),
    [
        ("chin_bottom", 1, -500.0, 3, 500),  # open_jaw, downwards
        ("chin_bottom", 2, 100.0, 14, round(100 * 5.1 / 2.6)),  # thrust_jaw: our depth is in mouth widths
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
def test_parameters_have_their_point_direction_and_unit(
    point: str, axis: int, value: float, fap: int, expected: int
) -> None:
    faps = one(point, axis, value)
    assert faps.values[0, fap - 1] == expected
    assert np.count_nonzero(faps.values) == 1
    assert faps.used[fap - 1]


def test_gaze_and_head_are_angles() -> None:
    displacements = np.zeros((CONTROL_POINT_COUNT, 3))
    displacements[CONTROL_POINT_INDEX["pupil_l"], :2] = 192 * np.sin([0.2, 0.1])
    pose = np.array([0.1, 0.0, 0.0, 0.3, 0.0, -3.0])  # the chin goes down: pitch is negative upwards
    values = to_faps(motion(displacements, poses=pose[None]), FAPU).values[0]
    np.testing.assert_allclose(values[[22, 23, 24, 25]], [20000, 0, -10000, 0], atol=1)
    np.testing.assert_allclose(values[[47, 48, 49]], [10000, 0, 0], atol=1)


def test_without_a_pose_the_head_is_left_out() -> None:
    assert not one("chin_bottom", 1, 1.0).used[47:50].any()
    assert not one("chin_bottom", 1, 1.0).used[:2].any()


def test_a_motion_in_mesh_units_is_refused() -> None:
    with pytest.raises(ValueError, match="FAPU units"):
        to_faps(MotionClip(25.0, "mesh", np.zeros((1, CONTROL_POINT_COUNT, 3), np.float32)), FAPU)


@same_folder
@given(
    values=hnp.arrays(np.int32, st.tuples(st.integers(1, 5), st.just(FAP_COUNT)), elements=st.integers(-99999, 99999)),
    used=hnp.arrays(np.bool_, FAP_COUNT),
    fps=st.integers(1, 120),
)
def test_what_is_written_is_read_again(tmp_path: Path, values: np.ndarray, used: np.ndarray, fps: int) -> None:
    used[:2] = False
    values[:, ~used] = 0
    write_fap(tmp_path / "a.fap", FapMotion(float(fps), values, used, "smile"))
    read = read_fap(tmp_path / "a.fap")
    np.testing.assert_array_equal(read.values, values)
    np.testing.assert_array_equal(read.used, used)
    assert (read.fps, read.name) == (fps, "smile")


def test_the_file_looks_as_other_players_expect(tmp_path: Path) -> None:
    write_fap(tmp_path / "a.fap", to_faps(motion(*[load_action_units()[26]] * 2), FAPU))
    header, mask, first, _, second = (tmp_path / "a.fap").read_text().splitlines()
    assert header == "2.1 conf 25 2"
    assert len(mask.split()) == FAP_COUNT
    assert first.split()[0] == "0" and second.split()[0] == "1"
    assert len(first.split()) == 1 + mask.split().count("1")
    assert int(first.split()[1]) > 400  # the jaw is open


def test_greta_s_files_are_read_visemes_skipped(tmp_path: Path) -> None:
    (tmp_path / "a.fap").write_text("# a comment\n" + GRETA)
    read = read_fap(tmp_path / "a.fap")
    assert (read.fps, read.name, read.values.shape) == (25.0, "1-Welcome_1.fap", (1, FAP_COUNT))
    assert not read.used.any()


@pytest.mark.parametrize(
    ("text", "line", "expected"),
    [
        ("", 1, "expected `2.1 NAME FPS FRAMES`"),
        ("2.0 a 25 1\n", 1, "expected `2.1 NAME FPS FRAMES`"),
        ("2.1 a 0 1\n", 1, "FPS at most 1000"),
        ("2.1 a 25 x\n", 1, "expected `2.1 NAME FPS FRAMES`"),
        ("2.1 a 25 1\n0 1\n", 2, "expected a mask of 68 zeros and ones"),
        (f"2.1 a 25 1\n{NO_MASK}\n1\n", 3, "expected the frame's number, 0, and 0 values"),
        (f"2.1 a 25 1\n{NO_MASK}\n", 3, "expected the frame's number"),
        (f"2.1 a 25 2\n{NO_MASK}\n0\n", 3, "expected 2 frames, found 1"),
    ],
)
def test_each_fault_is_named(tmp_path: Path, text: str, line: int, expected: str) -> None:
    (tmp_path / "bad.fap").write_text(text)
    with pytest.raises(FileFormatError) as error:
        read_fap(tmp_path / "bad.fap")
    assert expected in error.value.expected
    assert error.value.line == line


pieces = st.sampled_from([b"2.1 a 25 1\n", b"# x\n", NO_MASK.encode() + b"\n", b"1" + NO_MASK.encode()[1:] + b"\n",
                          b"0 1 2 3 4\n", b"0\n", b"1\n", b"\xff\n", b"\n", b"nan\n"])  # fmt: skip


@same_folder
@given(data=st.one_of(st.binary(max_size=200), st.lists(pieces, max_size=8).map(b"".join)))
def test_any_bytes_give_parameters_or_the_one_error(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "a.fap").write_bytes(data)
    try:
        read = read_fap(tmp_path / "a.fap")
    except FileFormatError:
        return
    assert read.values.shape[1] == FAP_COUNT


def test_a_name_of_two_words_is_refused(tmp_path: Path) -> None:
    faps = FapMotion(25.0, np.zeros((1, FAP_COUNT), np.int32), np.zeros(FAP_COUNT, np.bool_), "two words")
    with pytest.raises(ValueError, match="one word"):
        write_fap(tmp_path / "a.fap", faps)
