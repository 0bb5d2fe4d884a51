import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from conf.face.portrait.motion_deadband import (
    DESCRIPTOR_STEPS,
    MOTION_THRESHOLD_CM,
    POINT_CM,
    VERTEX_DEADBAND_CM,
    dampen_descriptor,
    dampen_points,
    dampen_vertices,
    stillness_weight,
)

CENTIMETRE = 0.03
X, Y = np.meshgrid(np.linspace(-0.3, 0.3, 9), np.linspace(-0.3, 0.3, 9))
PHOTO = np.stack([X.ravel(), Y.ravel()], axis=1)
FACE = np.linalg.norm(PHOTO, axis=1) < 0.25


def dampened(motion_cm: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the motion since the photo in cm that remains of a motion in cm."""
    return (dampen_vertices(PHOTO + motion_cm * CENTIMETRE, PHOTO, FACE, CENTIMETRE) - PHOTO) / CENTIMETRE


def test_jitter_is_suppressed_and_motion_is_kept() -> None:
    noise = np.random.default_rng(1).normal(0, VERTEX_DEADBAND_CM / 8, PHOTO.shape)
    assert np.abs(dampened(noise)).max() < np.abs(noise).max() / 5
    far = np.full_like(PHOTO, 3 * VERTEX_DEADBAND_CM)
    np.testing.assert_allclose(dampened(far), far, rtol=1e-3)


def test_local_motion_in_a_still_face_is_kept() -> None:
    motion = np.zeros_like(PHOTO)
    motion[40] = (0.0, 2 * MOTION_THRESHOLD_CM)
    np.testing.assert_allclose(dampened(motion)[40], motion[40], rtol=0.02)


@pytest.mark.slow
@given(st.floats(0, 1), st.floats(0, 0.01))
def test_the_dead_band_is_continuous_and_monotonic(cm: float, more: float) -> None:
    near, far = (dampened(np.full_like(PHOTO, (d, 0.0)))[0, 0] for d in (cm, cm + more))
    assert -1e-12 <= far - near <= 3 * more + 1e-12


def test_jitter_of_a_control_point_is_suppressed_and_motion_is_kept() -> None:
    motion = np.array([(0.2 * POINT_CM, 0.0, 0.0), (0.0, 4 * POINT_CM, 0.0)])
    remaining = dampen_points(motion)
    assert np.linalg.norm(remaining[0]) < 0.05 * np.linalg.norm(motion[0])
    np.testing.assert_allclose(remaining[1], motion[1], rtol=1e-6)


def test_stillness_is_1_at_the_photographed_positions_only() -> None:
    assert stillness_weight(PHOTO, PHOTO, FACE, CENTIMETRE) == 1.0
    assert stillness_weight(PHOTO + 3 * VERTEX_DEADBAND_CM * CENTIMETRE, PHOTO, FACE, CENTIMETRE) < 0.01
    positions = PHOTO.copy()
    positions[~FACE] += 1.0
    assert stillness_weight(positions, PHOTO, FACE, CENTIMETRE) == 1.0


def test_jitter_of_a_descriptor_is_suppressed_in_a_still_face() -> None:
    photo, noise, smile = np.full(7, 5.0), np.eye(7)[0] * DESCRIPTOR_STEPS / 4, np.eye(7)[1] * DESCRIPTOR_STEPS * 2.5
    assert np.linalg.norm(dampen_descriptor(photo + noise, photo, 1.0) - photo) < 0.1 * np.linalg.norm(noise)
    np.testing.assert_allclose(dampen_descriptor(photo + smile, photo, 1.0), photo + smile, atol=0.1)
    np.testing.assert_array_equal(dampen_descriptor(photo + noise, photo, 0.0), photo + noise)
