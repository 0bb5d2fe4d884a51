"""Quantised frames are values: equal when they are equal."""

from conf.protocol.codec.quantised_frame import FACE_CENTRE, LOG_SCALE, POSE_VALUES, ROTATION, QuantisedFrame


def test_the_pose_comes_first_and_is_whole() -> None:
    values = list(range(POSE_VALUES))
    assert [values[LOG_SCALE], *values[ROTATION], *values[FACE_CENTRE]] == values


def test_frames_are_equal_by_value() -> None:
    assert QuantisedFrame((1, 2)) == QuantisedFrame((1, 2), staggered=False, residuals={})
    assert QuantisedFrame((1, 2)) != QuantisedFrame((1, 2), staggered=True)
    assert QuantisedFrame((1, 2)) != QuantisedFrame((1, 2), residuals={3: (1, 0, 0)})
