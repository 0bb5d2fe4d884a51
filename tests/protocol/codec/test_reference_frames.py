"""The memory of frames is bounded and never guesses."""

import pytest

from conf.errors import ProtocolError
from conf.protocol.codec.quantised_frame import QuantisedFrame
from conf.protocol.codec.reference_frames import KEPT, History, MissingReferenceError


def test_a_missing_frame_is_named() -> None:
    with pytest.raises(MissingReferenceError, match="frame 7 is the reference and is not known") as caught:
        History().recall(7)
    assert caught.value.number == 7
    assert isinstance(caught.value, ProtocolError)


def test_old_frames_are_forgotten() -> None:
    history = History()
    for number in range(10_000):
        history.remember(number, QuantisedFrame((number,)))
    assert len(list(history.numbers())) == KEPT + 1
    assert history.recall(9_999 - KEPT) == QuantisedFrame((9_999 - KEPT,))
    assert history.find(9_998 - KEPT) is None


def test_a_late_frame_is_kept_too() -> None:
    history = History()
    history.remember(100, QuantisedFrame((1,)))
    history.remember(90, QuantisedFrame((2,)))
    assert history.newest == 100
    assert history.find(90) == QuantisedFrame((2,))
