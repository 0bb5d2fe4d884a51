"""The transform: it agrees with the independent decoder, and its two directions are inverse."""

from dataclasses import replace
from math import exp

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from conf.protocol.codec.model import load_models
from conf.protocol.codec.reference_frames import LOG_SCALE, POSE_VALUES, QuantisedFrame
from tests.protocol.independent_decoder import Frame, PayloadReader
from tests.support.synthetic_motion import talking

TRANSFORM = load_models()["live"].transform
COUNT = len(TRANSFORM.reconstruction_shift)
VALUES = st.lists(st.integers(-60, 60), min_size=COUNT, max_size=COUNT).map(tuple)
CHANGES = st.lists(st.integers(-2, 2), min_size=COUNT, max_size=COUNT)
RESIDUALS = st.dictionaries(st.integers(0, 49), st.tuples(*[st.integers(-90, 90)] * 3), max_size=3)
ZERO = (0,) * COUNT
SMALL_ROTATION = (0, 1, 0, 0, *ZERO[4:])
READER = PayloadReader()


def independent_inverse(
    frame: QuantisedFrame, previous: QuantisedFrame | None = None
) -> tuple[np.ndarray[tuple[int, ...], np.dtype[np.float64]], np.ndarray[tuple[int, ...], np.dtype[np.float64]]]:
    """Return displacements and pose of a frame by the independent decoder."""
    READER.frames = {("live", 1): Frame(list(frame.values), frame.staggered, frame.residuals)}
    if previous:
        READER.frames["live", 0] = Frame(list(previous.values), previous.staggered)
    return READER.motion("live", 1)


@pytest.mark.slow
@given(VALUES, CHANGES, st.booleans(), RESIDUALS)
@example(SMALL_ROTATION, [0] * COUNT, False, {3: (1, 2, 3)})
@example(ZERO, [1] * COUNT, False, {})
def test_frames_are_decoded_as_by_the_independent_decoder(
    values: tuple[int, ...], changes: list[int], staggered: bool, residuals: dict[int, tuple[int, int, int]]
) -> None:
    frame = QuantisedFrame(values, staggered, residuals)
    previous = QuantisedFrame(tuple(v + c for v, c in zip(values, changes, strict=True)), staggered)
    for before in (None, previous):
        displacements, pose = TRANSFORM.inverse(frame, before)
        expected = independent_inverse(frame, before)
        np.testing.assert_allclose(displacements, expected[0], rtol=1e-6, atol=1e-3)
        np.testing.assert_allclose(pose, expected[1], rtol=1e-9, atol=1e-12)


@pytest.mark.slow
@given(VALUES)
def test_forward_undoes_inverse(values: tuple[int, ...]) -> None:
    displacements, pose = TRANSFORM.inverse(QuantisedFrame(values))
    back = TRANSFORM.forward(displacements, pose, log_scale=values[LOG_SCALE])
    np.testing.assert_allclose(back, values, atol=1e-2)
    np.testing.assert_allclose(back[:POSE_VALUES], values[:POSE_VALUES], atol=1e-9)
    assert TRANSFORM.log_scale(pose) == pytest.approx(values[LOG_SCALE], abs=1e-6)


def test_the_face_centre_is_measured_in_the_size_that_is_sent() -> None:
    [frame] = talking(1)
    reference = TRANSFORM.forward(frame.displacements, frame.pose, log_scale=0)
    larger = TRANSFORM.forward(frame.displacements, frame.pose, log_scale=10)
    np.testing.assert_allclose(larger[4:6], reference[4:6] / exp(10 * TRANSFORM.pose_steps[LOG_SCALE]))
    assert (reference[LOG_SCALE], larger[LOG_SCALE]) == (0, 10)
    np.testing.assert_array_equal(np.delete(larger, [0, 4, 5]), np.delete(reference, [0, 4, 5]))


def test_components_are_orthonormal_in_steps() -> None:
    assert np.allclose(TRANSFORM.inverse_matrix @ TRANSFORM.forward_matrix, np.eye(COUNT - POSE_VALUES), atol=1e-5)


@pytest.mark.slow
@given(VALUES, VALUES)
def test_the_reconstruction_shift_is_at_most_half_a_step(values: tuple[int, ...], before: tuple[int, ...]) -> None:
    frame, earlier = QuantisedFrame(values), QuantisedFrame(before, staggered=True)
    distance = TRANSFORM.dequantise(earlier) - TRANSFORM.dequantise(frame)
    _, plain = TRANSFORM.inverse(frame)
    _, shifted = TRANSFORM.inverse(frame, earlier)
    steps = (shifted[:3] - plain[:3]) / TRANSFORM.pose_steps[1:4]
    assert np.all(np.abs(steps) <= 0.5 + 1e-9)
    assert np.all(steps * distance[1:4] >= -1e-9)


def test_a_frame_equal_to_the_previous_one_is_not_shifted() -> None:
    frame = QuantisedFrame(tuple(range(COUNT)))
    plain, shifted = TRANSFORM.inverse(frame), TRANSFORM.inverse(frame, frame)
    assert np.array_equal(plain[0], shifted[0])
    assert np.array_equal(plain[1], shifted[1])


def test_staggered_values_are_offset_by_half_a_step() -> None:
    frame = QuantisedFrame(ZERO)
    offset = TRANSFORM.dequantise(replace(frame, staggered=True)) - TRANSFORM.dequantise(frame)
    assert set(offset.tolist()) == {0.0, 0.5}
    assert offset[LOG_SCALE] == 0


def test_the_residual_is_what_components_cannot_represent() -> None:
    [frame] = talking(1)
    residual = TRANSFORM.residual(frame.displacements) * TRANSFORM.residual_steps
    inside = (frame.displacements - residual).astype(np.float32)
    assert np.abs(TRANSFORM.residual(inside)).max() < 1e-3
    carried, original = (TRANSFORM.forward(part, frame.pose, log_scale=0) for part in (inside, frame.displacements))
    np.testing.assert_allclose(carried, original, atol=1e-2)


def test_a_pose_error_is_compensated_by_the_coupling() -> None:
    for axis in range(POSE_VALUES):
        error = np.zeros(POSE_VALUES)
        error[axis] = 0.5
        np.testing.assert_allclose(
            TRANSFORM.compensate_pose_error(error), READER.arrays["expressions_coupling"][axis] / 2
        )
