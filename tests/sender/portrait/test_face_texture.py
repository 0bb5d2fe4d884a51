import numpy as np
import pytest

from conf.face.portrait.warp import PortraitWarp
from conf.sender.portrait.face_texture import FaceTexture, similarities
from tests.support.portrait_subjects import shaded_person
from tests.support.synthetic_portrait import face_shape


@pytest.mark.slow
def test_a_texture_does_not_depend_on_brightness_and_follows_the_mesh() -> None:
    warp = PortraitWarp(face_shape())
    texture, pixels, positions = FaceTexture(warp), shaded_person(), warp.mesh.positions
    described = texture.describe(pixels, positions)
    assert np.isfinite(described).all() and 0 < np.linalg.norm(described) < 1.2
    brighter = np.clip(pixels.astype(int) + 9, 0, 255).astype(np.uint8)
    shifted = texture.describe(np.roll(pixels, 5, axis=1), positions + np.array([5 / len(pixels), 0]))
    for other in (texture.describe(brighter, positions), shifted):
        assert np.linalg.norm(other - described) < 0.1 * np.linalg.norm(described)
    unmoved = texture.describe(np.roll(pixels, 5, axis=1), positions)
    assert np.linalg.norm(unmoved - described) > 0.5 * np.linalg.norm(described)


def test_similarity_is_that_of_the_blend_and_falls_with_its_contrast() -> None:
    frame, noise = np.array([0.6, 0.0]), np.array([0.0, 0.6])
    textures = np.array([frame, frame, noise, np.zeros(2)])  # one frame, three images

    def similarity(*weights: float) -> float:
        return float(similarities(textures @ textures.T, np.array([weights]))[0])

    assert similarity(1, 0, 0) == pytest.approx(1)
    assert similarity(0, 1, 0) == similarity(0, 0, 1) == pytest.approx(1 - 0.36)
    assert similarity(0.5, 0, 0.5) == pytest.approx(1 - 0.36 * (1 - 2 * 0.5 / 1.25))
    assert similarity(0.5, 0, 0.5) < similarity(0.8, 0, 0.2) < 1


def test_frames_are_compared_one_by_one() -> None:
    textures = np.random.default_rng(2).normal(size=(6, 20)) / 5
    weights = np.random.default_rng(3).dirichlet(np.ones(3), size=3)
    together = similarities(textures @ textures.T, weights)
    for row, expected in enumerate(together):
        rows = textures[[row, 3, 4, 5]]
        assert similarities(rows @ rows.T, weights[row : row + 1])[0] == pytest.approx(expected)
