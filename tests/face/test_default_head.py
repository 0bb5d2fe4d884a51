import pytest

from conf.face.control_points import PUPILS
from conf.face.default_head import DEFAULT_HEAD, EYE_MIDPOINT, default_joints, default_points


def test_its_files_are_there_and_its_eyes_where_they_are_said_to_be() -> None:
    assert DEFAULT_HEAD.is_file()
    assert default_points()[PUPILS].mean(axis=0) == pytest.approx(EYE_MIDPOINT, abs=2e-3)


def test_its_eyeballs_lie_behind_its_pupils() -> None:
    joints = default_joints()
    for centre, pupil in zip(joints.eyes.values(), default_points()[PUPILS], strict=True):
        assert centre[:2] == pytest.approx(pupil[:2], abs=0.02)
        assert pupil[2] > centre[2] + 1
    assert joints.hinge is not None
