"""What frames are predicted from."""

import pytest

from conf.protocol.codec.model import load_models
from conf.protocol.codec.payload_header import PayloadHeader
from conf.protocol.codec.prediction import first_context, next_context
from conf.protocol.codec.quantised_frame import QuantisedFrame
from conf.protocol.codec.reference_frames import MissingReferenceError, ReferenceFrames

MODEL = load_models()["live"]
FRAMES = [QuantisedFrame((n,) * len(MODEL.default_reference.values)) for n in range(5)]


def history() -> ReferenceFrames:
    known = ReferenceFrames()
    for number, frame in enumerate(FRAMES):
        known.add(number, frame)
    return known


def test_without_a_reference_the_standing_frame_is_it() -> None:
    context = first_context(MODEL, PayloadHeader("live", 1, 1, 0, second_reference=False), 4, history().require)
    assert (context.row, context.reference, context.second_reference) == (0, MODEL.default_reference, None)


def test_the_reference_and_its_companion_are_found_by_age() -> None:
    context = first_context(MODEL, PayloadHeader("live", 1, 1, 2, second_reference=True), 5, history().require)
    assert (context.reference, context.second_reference) == (FRAMES[3], FRAMES[2])
    assert context.row == MODEL.second_reference_rows[2]


def test_an_unknown_companion_is_missed_as_well() -> None:
    with pytest.raises(MissingReferenceError, match="frame -1"):
        first_context(MODEL, PayloadHeader("live", 1, 1, 5, second_reference=True), 5, history().require)


def test_within_a_bundle_the_frames_before_serve() -> None:
    header = PayloadHeader("live", 3, 2, 0, second_reference=False)
    one, two = next_context(MODEL, header, FRAMES[:1]), next_context(MODEL, header, FRAMES[:2])
    assert (one.row, one.reference, one.second_reference) == (MODEL.rows[2], FRAMES[0], None)
    assert (two.row, two.reference, two.second_reference) == (MODEL.second_reference_rows[2], FRAMES[1], FRAMES[0])
