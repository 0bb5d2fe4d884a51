"""The patch: precision, limits and errors."""

from contextlib import nullcontext
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.portrait.patch import MAX_SIDE, MIN_STEP, STEP_COUNT, decode_patch, encode_patch, step_size
from conf.protocol.portrait.probability_model import REGIONS, load_portrait_model
from tests.protocol.independent_decoder import read_patch
from tests.support.portrait_objects import example_patch


@pytest.mark.parametrize("region", range(len(REGIONS)))
def test_a_patch_is_decoded_as_it_was_encoded(region: int) -> None:
    sent = example_patch(region=region)
    data = encode_patch(sent)
    decoded = decode_patch(data)
    np.testing.assert_array_equal(decoded.descriptor, sent.descriptor)
    np.testing.assert_allclose(decoded.points, np.rint(sent.points * 127.5) / 127.5)
    assert (decoded.photo_number, decoded.region, decoded.slot) == tuple(data[:3]) == (1, region, 3)
    assert (decoded.size, decoded.step) == ((48, 42), 7)
    for expected, plane in zip(sent.coefficients, decoded.coefficients, strict=True):
        np.testing.assert_array_equal(plane, expected)
    read = read_patch(data[3:], REGIONS[region])
    assert (read.size, read.step) == ((48, 42), 7)


@pytest.mark.parametrize(("size", "step"), [((1, 1), 0), ((96, 96), 47), ((96, 8), 1)])
def test_sizes_and_steps_up_to_the_limits_can_be_sent(size: tuple[int, int], step: int) -> None:
    decoded = decode_patch(encode_patch(replace(example_patch(), size=size, step=step, coefficients=())))
    assert (decoded.size, decoded.step) == (size, step)
    assert (MAX_SIDE, STEP_COUNT) == (96, 48)


def test_coefficients_are_rounded_by_rate_and_distortion() -> None:
    planes = [np.zeros_like(plane, np.float64) for plane in example_patch().coefficients]
    planes[0][1, 2, :3] = (4.7, 0.2, -0.9)
    planes[0][0, 0, :3] = (0.3, -0.4, 0.3)
    planes[1][0, 0, :2] = (3.55, 2.5)
    decoded = decode_patch(encode_patch(replace(example_patch(), coefficients=planes))).coefficients
    np.testing.assert_array_equal(decoded[0][1, 2, :4], (5, 0, -1, 0))
    assert not decoded[0][0, 0].any() and not decoded[2].any()
    np.testing.assert_array_equal(decoded[1][0, 0, :3], (3, 2, 0))


def test_a_patch_without_coefficients_costs_little_more_than_its_points() -> None:
    planes = [np.zeros_like(plane) for plane in example_patch().coefficients]
    assert len(encode_patch(example_patch())) > 2 * len(encode_patch(replace(example_patch(), coefficients=planes)))


def test_eight_steps_are_an_octave() -> None:
    assert step_size(0) == MIN_STEP == 3
    assert step_size(8) == pytest.approx(6)
    assert step_size(4) == pytest.approx(3 * 2**0.5)


@pytest.mark.parametrize(("region", "slot"), [(2, 0), (-1, 0), (0, 16), (0, -1)])
def test_an_invalid_region_or_slot_cannot_be_encoded(region: int, slot: int) -> None:
    with pytest.raises(ValueError, match=f"there is no region {region} with a slot {slot}"):
        encode_patch(replace(example_patch(), region=region, slot=slot))


@pytest.mark.parametrize(("slot", "region"), [(0, 0), (15, 1)])
def test_valid_regions_and_slots_are_accepted(slot: int, region: int) -> None:
    assert decode_patch(encode_patch(replace(example_patch(region=region), slot=slot))).slot == slot


def test_another_model_can_be_given() -> None:
    model = load_portrait_model()
    other = replace(
        model, regions=[replace(region, descriptor_scale=region.descriptor_scale + 9) for region in model.regions]
    )
    assert encode_patch(example_patch(), model=other) != encode_patch(example_patch())


GOOD = encode_patch(example_patch())


@pytest.mark.parametrize(
    ("data", "error"),
    [
        (b"", "a patch cut off"),
        (GOOD[:2], "a patch cut off"),
        (GOOD[:3], "a patch far from the face"),
        (GOOD[:1] + b"\2" + GOOD[2:], "invalid region or slot"),
        (GOOD[:2] + b"\x10" + GOOD[3:], "invalid region or slot"),
        (GOOD + b"\1", "padded"),
    ],
)
def test_invalid_patches_are_rejected(data: bytes, error: str) -> None:
    with pytest.raises(ProtocolError, match=error):
        decode_patch(data)


@pytest.mark.parametrize(
    ("descriptor", "point", "valid"),
    [(127, 2.0, True), (-127, -2.0, True), (128, 0.0, False), (-128, 0.0, False), (0, 2.01, False), (0, -2.01, False)],
)
def test_a_patch_far_from_the_face_is_rejected(descriptor: int, point: float, valid: bool) -> None:
    patch = example_patch()
    points = patch.points.copy()
    points[1, 1] = point
    wide: Any = patch.descriptor.astype(np.int16)
    wide[0] = descriptor
    data = encode_patch(replace(patch, points=points, descriptor=wide))
    with nullcontext() if valid else pytest.raises(ProtocolError, match="far from the face"):
        decode_patch(data)


@pytest.mark.slow
@given(st.binary(max_size=400))
def test_any_bytes_give_a_small_patch_or_protocol_error(data: bytes) -> None:
    try:
        decoded = decode_patch(bytes((1, 0, 0)) + data)
    except ProtocolError:
        return
    assert max(decoded.size) <= MAX_SIDE and decoded.step < STEP_COUNT
    assert np.abs(decoded.points).max() <= 2
