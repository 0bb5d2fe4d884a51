from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.portrait.patch import (
    MAX_SIDE,
    MIN_STEP,
    STEP_COUNT,
    STEPS_PER_OCTAVE,
    decode_patch,
    encode_patch,
    step_size,
)
from conf.protocol.portrait.probability_model import REGIONS
from tests.support.portrait_objects import example_patch


@pytest.mark.parametrize("region", range(len(REGIONS)))
def test_a_patch_survives(region: int) -> None:
    sent = example_patch(region=region)
    got = decode_patch(encode_patch(sent))
    np.testing.assert_array_equal(got.descriptor, sent.descriptor)
    np.testing.assert_allclose(got.points, sent.points, atol=0.005)
    assert (got.photo_number, got.region, got.slot, got.size, got.step) == (1, region, 3, (48, 42), 7)
    for mine, theirs in zip(sent.coefficients, got.coefficients, strict=True):
        np.testing.assert_array_equal(theirs, mine)


def test_what_is_no_whole_step_is_rounded_or_left_out() -> None:
    planes = [np.zeros_like(plane, np.float64) for plane in example_patch().coefficients]
    planes[0][1, 2, :3] = (4.7, 0.2, -0.9)
    planes[0][0, 0, :3] = (0.3, -0.4, 0.3)
    got = decode_patch(encode_patch(replace(example_patch(), coefficients=planes))).coefficients
    np.testing.assert_array_equal(got[0][1, 2, :4], (5, 0, -1, 0))
    assert not got[0][0, 0].any() and not got[1].any() and not got[2].any()


def test_a_patch_that_adds_nothing_costs_little_more_than_its_points() -> None:
    planes = [np.zeros_like(plane) for plane in example_patch().coefficients]
    assert len(encode_patch(example_patch())) > 2 * len(encode_patch(replace(example_patch(), coefficients=planes)))


def test_steps_grow_by_octaves() -> None:
    assert step_size(0) == MIN_STEP
    assert step_size(STEPS_PER_OCTAVE) == pytest.approx(2 * MIN_STEP)


def test_patches_that_cannot_travel_are_refused() -> None:
    for wrong in (replace(example_patch(), region=2), replace(example_patch(), slot=200)):
        with pytest.raises(ValueError, match="there is no region"):
            encode_patch(wrong)


def test_wrong_patches_are_refused() -> None:
    good = encode_patch(example_patch())
    for wrong in (b"", good[:2], good[:1] + b"\2" + good[2:], good[:2] + b"\x10" + good[3:]):
        with pytest.raises(ProtocolError):
            decode_patch(wrong)
    with pytest.raises(ProtocolError, match="far from the face"):
        decode_patch(encode_patch(replace(example_patch(), points=example_patch().points + 3)))


@given(st.binary(max_size=400))
def test_whatever_the_bytes_a_patch_is_small_or_refused(data: bytes) -> None:
    try:
        got = decode_patch(bytes((1, 0, 0)) + data)
    except ProtocolError:
        return
    assert max(got.size) <= MAX_SIDE and got.step < STEP_COUNT
    assert np.abs(got.points).max() <= 2
