"""The memory of frames is bounded and never guesses."""

import pytest

from conf.errors import ProtocolError
from conf.protocol.codec.reference_frames import MAX_TICKS, MissingReferenceError, QuantisedFrame, ReferenceFrames


def test_a_missing_frame_is_named() -> None:
    with pytest.raises(MissingReferenceError, match="frame 7 is the reference and is not known") as caught:
        ReferenceFrames().require(7)
    assert caught.value.frame_number == 7
    assert isinstance(caught.value, ProtocolError)


def test_old_frames_are_forgotten() -> None:
    history = ReferenceFrames()
    for number in range(10_000):
        history.add(number, QuantisedFrame((number,)))
    assert len(list(history.numbers())) == MAX_TICKS + 1
    assert history.require(9_999 - MAX_TICKS) == QuantisedFrame((9_999 - MAX_TICKS,))
    assert history.get(9_998 - MAX_TICKS) is None


def test_a_late_frame_is_kept_too() -> None:
    history = ReferenceFrames()
    history.add(100, QuantisedFrame((1,)))
    history.add(90, QuantisedFrame((2,)))
    assert history.newest == 100
    assert history.get(90) == QuantisedFrame((2,))
