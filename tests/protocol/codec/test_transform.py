"""The linear part: what is analysed comes back when shown, within a step."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.codec.model import load_models
from conf.protocol.codec.reference_frames import LOG_SCALE, POSE_VALUES, QuantisedFrame
from tests.support.synthetic_motion import talking

TRANSFORM = load_models()["live"].transform
COUNT = len(TRANSFORM.reconstruction_shift)
VALUES = st.lists(st.integers(-60, 60), min_size=COUNT, max_size=COUNT).map(tuple)


@given(VALUES)
def test_analysis_undoes_synthesis(values: tuple[int, ...]) -> None:
    displacements, pose = TRANSFORM.inverse(QuantisedFrame(values))
    back = TRANSFORM.forward(displacements, pose, log_scale=values[LOG_SCALE])
    assert np.allclose(back, values, atol=1e-2)
    assert abs(TRANSFORM.log_scale(pose) - values[LOG_SCALE]) < 1e-6


def test_components_are_orthonormal_in_steps() -> None:
    assert np.allclose(TRANSFORM.inverse_matrix @ TRANSFORM.forward_matrix, np.eye(COUNT - POSE_VALUES), atol=1e-5)


@given(VALUES, VALUES)
def test_leaning_never_leaves_the_step(values: tuple[int, ...], before: tuple[int, ...]) -> None:
    frame, earlier = QuantisedFrame(values), QuantisedFrame(before, staggered=True)
    way = TRANSFORM.dequantise(earlier) - TRANSFORM.dequantise(frame)
    _, plain = TRANSFORM.inverse(frame)
    _, leaned = TRANSFORM.inverse(frame, earlier)
    steps = (leaned[:3] - plain[:3]) / TRANSFORM.pose_steps[1:4]
    assert np.all(np.abs(steps) <= 0.5 + 1e-9)
    assert np.all(steps * way[1:4] >= -1e-9)


def test_a_frame_like_the_one_before_does_not_lean() -> None:
    frame = QuantisedFrame(tuple(range(COUNT)))
    plain, leaned = TRANSFORM.inverse(frame), TRANSFORM.inverse(frame, frame)
    assert np.array_equal(plain[0], leaned[0])
    assert np.array_equal(plain[1], leaned[1])


def test_staggered_values_count_from_half_a_step() -> None:
    frame = QuantisedFrame((0,) * COUNT)
    moved = TRANSFORM.dequantise(replace(frame, staggered=True)) - TRANSFORM.dequantise(frame)
    assert set(moved.tolist()) == {0.0, 0.5}
    assert moved[LOG_SCALE] == 0


def test_the_residual_is_what_components_cannot_carry() -> None:
    [frame] = talking(1)
    residual = TRANSFORM.residual(frame.displacements) * TRANSFORM.residual_steps
    inside = (frame.displacements - residual).astype(np.float32)
    assert np.abs(TRANSFORM.residual(inside)).max() < 1e-3
