import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from conf.face.portrait.settle import OWN_CM, POINT_CM, STILL_CM, settle, settle_points

CENTIMETRE = 0.03
X, Y = np.meshgrid(np.linspace(-0.3, 0.3, 9), np.linspace(-0.3, 0.3, 9))
PHOTO = np.stack([X.ravel(), Y.ravel()], axis=1)
FACE = np.linalg.norm(PHOTO, axis=1) < 0.25


def settled(moved_cm: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far in cm vertices are from the photograph that were moved so far."""
    return (settle(PHOTO + moved_cm * CENTIMETRE, PHOTO, FACE, CENTIMETRE) - PHOTO) / CENTIMETRE


def test_noise_goes_and_movement_stays() -> None:
    noise = np.random.default_rng(1).normal(0, STILL_CM / 8, PHOTO.shape)
    assert np.abs(settled(noise)).max() < np.abs(noise).max() / 5
    far = np.full_like(PHOTO, 3 * STILL_CM)
    np.testing.assert_allclose(settled(far), far, rtol=1e-3)


def test_what_moves_by_itself_in_a_still_face_is_left_alone() -> None:
    moved = np.zeros_like(PHOTO)
    moved[40] = (0.0, 2 * OWN_CM)
    np.testing.assert_allclose(settled(moved)[40], moved[40], rtol=0.02)


@given(st.floats(0, 1), st.floats(0, 0.01))
def test_a_little_more_motion_is_a_little_more_to_see(cm: float, more: float) -> None:
    near, far = (settled(np.full_like(PHOTO, (d, 0.0)))[0, 0] for d in (cm, cm + more))
    assert -1e-12 <= far - near <= 3 * more + 1e-12


def test_a_point_that_trembles_keeps_still_and_one_that_moves_moves() -> None:
    moved = np.array([(0.2 * POINT_CM, 0.0, 0.0), (0.0, 4 * POINT_CM, 0.0)])
    settled = settle_points(moved)
    assert np.linalg.norm(settled[0]) < 0.05 * np.linalg.norm(moved[0])
    np.testing.assert_allclose(settled[1], moved[1], rtol=1e-6)
