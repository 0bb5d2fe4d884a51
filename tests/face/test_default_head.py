import pytest

from conf.face.control_points import PUPILS
from conf.face.default_head import DEFAULT_HEAD, EYE_MIDPOINT, default_joints, default_points


def test_the_files_exist_and_the_eye_midpoint_is_right() -> None:
    assert DEFAULT_HEAD.is_file()
    assert default_points()[PUPILS].mean(axis=0) == pytest.approx(EYE_MIDPOINT, abs=2e-3)


def test_the_eyeballs_lie_behind_the_pupils() -> None:
    joints = default_joints()
    for centre, pupil in zip(joints.eyes.values(), default_points()[PUPILS], strict=True):
        assert centre[:2] == pytest.approx(pupil[:2], abs=0.02)
        assert pupil[2] > centre[2] + 1
    assert joints.hinge is not None
