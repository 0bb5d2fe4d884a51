import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.portrait.patch_features import FEATURES, MOUTH
from conf.face.portrait.warp import PortraitWarp
from conf.sender.portrait.occlusion import SKIN_PATCHES, AppearanceMatcher, CoverDetector, skin_texture_residual
from tests.support.portrait_subjects import landmarks, recent_frame, shaded_person, still, with_hand
from tests.support.synthetic_portrait import POSE, face_shape


@pytest.mark.slow
def test_a_hand_leaves_a_residual_and_light_a_small_shift_or_another_size_do_not() -> None:
    cover = CoverDetector(PortraitWarp(face_shape()), shaded_person())
    assert cover.residual(recent_frame()) < 0.02
    darker, moved = shaded_person(0.7, 20), np.roll(shaded_person(), 3, axis=0)
    half = np.asarray(cv2.resize(shaded_person(), None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA), np.uint8)
    for pixels in (darker, moved, half):
        assert cover.residual(recent_frame(pixels)) < 0.14
    assert cover.residual(recent_frame(with_hand())) > 0.18


@pytest.mark.slow
def test_correlation_is_independent_of_lighting_and_falls_where_a_hand_covers_the_face() -> None:
    matcher = AppearanceMatcher(PortraitWarp(face_shape()), shaded_person())
    hand = with_hand()
    for region, feature in enumerate(FEATURES):
        assert matcher.correlation(region, shaded_person(), still(), POSE) > 0.99
        assert matcher.correlation(region, shaded_person(0.7, 20), still(), POSE) > 0.95
        assert (matcher.correlation(region, hand, still(), POSE) < 0.7) == (feature is MOUTH)


def separate_skin_patches() -> NDArray[np.float32]:
    """Return landmarks whose skin patches do not overlap, as on a face."""
    found = landmarks()
    low, high = found[:, :2].min(axis=0), found[:, :2].max(axis=0)
    for i, patch in enumerate(SKIN_PATCHES):
        middle = low + (high - low) * ((i + 0.5) / len(SKIN_PATCHES), 0.7)
        angles = np.linspace(0, 2 * np.pi, len(patch), endpoint=False)
        found[list(patch), :2] = middle + 9 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return found


def test_a_brightness_gradient_has_no_texture_and_a_finger_has() -> None:
    height, width = shaded_person().shape[:2]
    bare = (np.linspace(60, 220, width)[None, :, None] * np.ones((height, 1, 3))).astype(np.uint8)
    points = separate_skin_patches()
    x, y = points[list(SKIN_PATCHES[2]), :2].mean(axis=0).astype(int).tolist()
    hand = bare.copy()
    cv2.line(hand, (x, y - 30), (x, y + 30), (250, 250, 250), 5)
    assert skin_texture_residual(bare, points) < 0.02 < 0.15 < skin_texture_residual(hand, points)


def test_a_face_beyond_the_border_or_of_a_few_pixels_gives_a_finite_texture() -> None:
    pixels, points = shaded_person(), separate_skin_patches()
    assert np.isfinite(skin_texture_residual(pixels, points - 500))
    assert np.isfinite(skin_texture_residual(pixels, np.asarray(points * 0.01, np.float32)))
