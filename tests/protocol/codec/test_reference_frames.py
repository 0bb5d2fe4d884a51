"""Quantised frames are values; the memory of them is bounded."""

import pytest

from conf.errors import ProtocolError
from conf.protocol.codec.reference_frames import (
    FACE_CENTRE,
    LOG_SCALE,
    MAX_TICKS,
    POSE_VALUES,
    ROTATION,
    MissingReferenceError,
    QuantisedFrame,
    ReferenceFrames,
)


def test_the_pose_values_come_first_and_are_complete() -> None:
    values = list(range(10))
    assert [values[LOG_SCALE], *values[ROTATION], *values[FACE_CENTRE]] == values[:POSE_VALUES] == [0, 1, 2, 3, 4, 5]
    assert values[FACE_CENTRE] == [4, 5]


def test_frames_are_equal_by_value() -> None:
    assert QuantisedFrame((1, 2)) == QuantisedFrame((1, 2), staggered=False, residuals={})
    assert QuantisedFrame((1, 2)) != QuantisedFrame((1, 2), staggered=True)
    assert QuantisedFrame((1, 2)) != QuantisedFrame((1, 2), residuals={3: (1, 0, 0)})


def test_a_missing_frame_is_named() -> None:
    with pytest.raises(MissingReferenceError, match="frame 7 is the reference and is not known"):
        ReferenceFrames().require(7)
    assert issubclass(MissingReferenceError, ProtocolError)


def test_old_frames_are_dropped() -> None:
    references = ReferenceFrames()
    assert references.newest == -1
    for number in range(300):
        references.add(number, QuantisedFrame((number,)))
    assert references.newest == 299
    assert list(references.numbers()) == list(range(299 - MAX_TICKS, 300))
    assert MAX_TICKS == 126
    assert references.require(299 - MAX_TICKS) == QuantisedFrame((299 - MAX_TICKS,))
    assert references.get(298 - MAX_TICKS) is None


def test_a_late_frame_is_stored() -> None:
    references = ReferenceFrames()
    references.add(100, QuantisedFrame((1,)))
    references.add(90, QuantisedFrame((2,)))
    assert references.newest == 100
    assert references.get(90) == QuantisedFrame((2,))


def test_a_frame_is_shown_with_those_before_it_up_to_a_gap() -> None:
    references = ReferenceFrames()
    for number in (10, 14, 16, 18):
        references.add(number, QuantisedFrame((number,)))
    assert references.before(18, 2) == [QuantisedFrame((16,)), QuantisedFrame((14,))]
    assert references.before(18, 4) == [QuantisedFrame((14,)), QuantisedFrame((10,))]
    assert references.before(14, 2) == [], "the frame two strides earlier alone does not help"
