"""The transform: it agrees with the independent decoder, and its two directions are inverse."""

from collections.abc import Sequence
from dataclasses import replace
from math import exp

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from conf.protocol.codec.model import load_models
from conf.protocol.codec.reconstruction import Reconstruction
from conf.protocol.codec.reference_frames import LOG_SCALE, POSE_VALUES, QuantisedFrame
from tests.protocol.independent_decoder import Frame, PayloadReader
from tests.support.synthetic_motion import talking

TRANSFORM = load_models()["live"].transform
COUNT = len(TRANSFORM.stagger)
VALUES = st.lists(st.integers(-60, 60), min_size=COUNT, max_size=COUNT).map(tuple)
CHANGES = st.lists(st.integers(-2, 2), min_size=COUNT, max_size=COUNT)
RESIDUALS = st.dictionaries(st.integers(0, 49), st.tuples(*[st.integers(-90, 90)] * 3), max_size=3)
ZERO = (0,) * COUNT
SMALL_ROTATION = (0, 1, 0, 0, *ZERO[4:])
READER = PayloadReader()


def independent_inverse(
    frame: QuantisedFrame, earlier: Sequence[QuantisedFrame]
) -> tuple[np.ndarray[tuple[int, ...], np.dtype[np.float64]], np.ndarray[tuple[int, ...], np.dtype[np.float64]]]:
    """Return displacements and pose of a frame by the independent decoder."""
    READER.frames = {("live", 2): Frame(list(frame.values), frame.staggered, frame.residuals)}
    for age, before in enumerate(earlier, 1):
        READER.frames["live", 2 - age] = Frame(list(before.values), before.staggered)
    return READER.motion("live", 2)


@pytest.mark.slow
@given(VALUES, CHANGES, CHANGES, st.booleans(), RESIDUALS)
@example(SMALL_ROTATION, [0] * COUNT, [1] * COUNT, False, {3: (1, 2, 3)})
@example(ZERO, [1] * COUNT, [-1] * COUNT, False, {})
def test_frames_are_decoded_as_by_the_independent_decoder(
    values: tuple[int, ...],
    changes: list[int],
    earlier_changes: list[int],
    staggered: bool,
    residuals: dict[int, tuple[int, int, int]],
) -> None:
    frame = QuantisedFrame(values, staggered, residuals)
    earlier = [
        QuantisedFrame(tuple(v + c for v, c in zip(values, by, strict=True)), staggered)
        for by in (changes, earlier_changes)
    ]
    for known in range(3):
        displacements, pose = TRANSFORM.inverse(frame, earlier[:known])
        expected = independent_inverse(frame, earlier[:known])
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


def test_the_components_follow_a_pose_that_is_estimated_inside_its_step() -> None:
    turn = np.zeros(COUNT)
    turn[1] = 0.4
    moved = replace(TRANSFORM, reconstruction=Reconstruction(turn, np.zeros((2, COUNT, COUNT))))
    frame, earlier = QuantisedFrame(ZERO), QuantisedFrame((0, 1, *ZERO[2:]))
    displacements, pose = moved.inverse(frame, [earlier])
    assert pose[0] == pytest.approx(0.4 * TRANSFORM.pose_steps[1])
    expected = -TRANSFORM.compensate_pose_error(turn[:POSE_VALUES]) @ TRANSFORM.inverse_matrix
    np.testing.assert_allclose(displacements.reshape(-1), expected, atol=1e-4)


def test_a_frame_equal_to_those_before_is_not_shifted() -> None:
    frame = QuantisedFrame(tuple(range(COUNT)))
    plain, shifted = TRANSFORM.inverse(frame), TRANSFORM.inverse(frame, [frame, frame])
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
        np.testing.assert_allclose(TRANSFORM.compensate_pose_error(error), READER.arrays["coupling"][axis] / 2)
