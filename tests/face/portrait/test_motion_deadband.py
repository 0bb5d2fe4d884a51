import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from conf.face.portrait.motion_deadband import (
    MOTION_THRESHOLD_CM,
    OWN_STEPS,
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


def settled(moved_cm: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far in cm vertices are from the photograph that were moved so far."""
    return (dampen_vertices(PHOTO + moved_cm * CENTIMETRE, PHOTO, FACE, CENTIMETRE) - PHOTO) / CENTIMETRE


def test_noise_goes_and_movement_stays() -> None:
    noise = np.random.default_rng(1).normal(0, VERTEX_DEADBAND_CM / 8, PHOTO.shape)
    assert np.abs(settled(noise)).max() < np.abs(noise).max() / 5
    far = np.full_like(PHOTO, 3 * VERTEX_DEADBAND_CM)
    np.testing.assert_allclose(settled(far), far, rtol=1e-3)


def test_what_moves_by_itself_in_a_still_face_is_left_alone() -> None:
    moved = np.zeros_like(PHOTO)
    moved[40] = (0.0, 2 * MOTION_THRESHOLD_CM)
    np.testing.assert_allclose(settled(moved)[40], moved[40], rtol=0.02)


@given(st.floats(0, 1), st.floats(0, 0.01))
def test_a_little_more_motion_is_a_little_more_to_see(cm: float, more: float) -> None:
    near, far = (settled(np.full_like(PHOTO, (d, 0.0)))[0, 0] for d in (cm, cm + more))
    assert -1e-12 <= far - near <= 3 * more + 1e-12


def test_a_point_that_trembles_keeps_still_and_one_that_moves_moves() -> None:
    moved = np.array([(0.2 * POINT_CM, 0.0, 0.0), (0.0, 4 * POINT_CM, 0.0)])
    settled = dampen_points(moved)
    assert np.linalg.norm(settled[0]) < 0.05 * np.linalg.norm(moved[0])
    np.testing.assert_allclose(settled[1], moved[1], rtol=1e-6)


def test_a_face_is_still_where_it_was_photographed_and_nowhere_else() -> None:
    assert stillness_weight(PHOTO, PHOTO, FACE, CENTIMETRE) == 1.0
    assert stillness_weight(PHOTO + 3 * VERTEX_DEADBAND_CM * CENTIMETRE, PHOTO, FACE, CENTIMETRE) < 0.01
    moved = PHOTO.copy()
    moved[~FACE] += 1.0
    assert stillness_weight(moved, PHOTO, FACE, CENTIMETRE) == 1.0


def test_in_a_still_face_a_feature_trembles_less_and_what_it_does_by_itself_stays() -> None:
    photo, noise, smile = np.full(7, 5.0), np.eye(7)[0] * OWN_STEPS / 4, np.eye(7)[1] * OWN_STEPS * 2.5
    assert np.linalg.norm(dampen_descriptor(photo + noise, photo, 1.0) - photo) < 0.1 * np.linalg.norm(noise)
    np.testing.assert_allclose(dampen_descriptor(photo + smile, photo, 1.0), photo + smile, atol=0.1)
    np.testing.assert_array_equal(dampen_descriptor(photo + noise, photo, 0.0), photo + noise)
