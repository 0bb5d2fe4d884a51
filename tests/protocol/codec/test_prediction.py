"""What frames are predicted from."""

import pytest

from conf.protocol.codec.model import load_models
from conf.protocol.codec.payload_header import BundleHeader
from conf.protocol.codec.prediction import first_context, next_context
from conf.protocol.codec.quantised_frame import QuantisedFrame
from conf.protocol.codec.reference_frames import History, MissingReferenceError

MODEL = load_models()["live"]
FRAMES = [QuantisedFrame((n,) * len(MODEL.standing.values)) for n in range(5)]


def history() -> History:
    known = History()
    for number, frame in enumerate(FRAMES):
        known.remember(number, frame)
    return known


def test_without_a_reference_the_standing_frame_is_it() -> None:
    context = first_context(MODEL, BundleHeader("live", 1, 1, 0, companion=False), 4, history().recall)
    assert (context.row, context.reference, context.companion) == (0, MODEL.standing, None)


def test_the_reference_and_its_companion_are_found_by_age() -> None:
    context = first_context(MODEL, BundleHeader("live", 1, 1, 2, companion=True), 5, history().recall)
    assert (context.reference, context.companion) == (FRAMES[3], FRAMES[2])
    assert context.row == MODEL.companion_rows[2]


def test_an_unknown_companion_is_missed_as_well() -> None:
    with pytest.raises(MissingReferenceError, match="frame -1"):
        first_context(MODEL, BundleHeader("live", 1, 1, 5, companion=True), 5, history().recall)


def test_within_a_bundle_the_frames_before_serve() -> None:
    header = BundleHeader("live", 3, 2, 0, companion=False)
    one, two = next_context(MODEL, header, FRAMES[:1]), next_context(MODEL, header, FRAMES[:2])
    assert (one.row, one.reference, one.companion) == (MODEL.rows[2], FRAMES[0], None)
    assert (two.row, two.reference, two.companion) == (MODEL.companion_rows[2], FRAMES[1], FRAMES[0])
