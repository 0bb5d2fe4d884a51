import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.face.portrait.photo_mesh import build_mesh, signed_areas
from conf.face.portrait.untangle import untangle
from tests.support.synthetic_portrait import face_shape

MESH = build_mesh(face_shape())


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_no_triangle_is_folded_for_any_target(seed: int, amplitude: float) -> None:
    rng = np.random.default_rng(seed)
    target = MESH.positions + 0.3 * amplitude * rng.normal(size=2) + amplitude * rng.normal(size=MESH.positions.shape)
    assert signed_areas(untangle(target, MESH), MESH.triangles).min() > 0


def test_a_target_without_folds_is_unchanged() -> None:
    target = MESH.positions * 1.1 + 0.02
    assert untangle(target, MESH) is target


def test_a_folded_sliver_is_corrected_with_small_offsets() -> None:
    areas = signed_areas(MESH.positions, MESH.triangles)
    sliver = MESH.triangles[np.argmin(areas)]
    corners = MESH.positions[sliver]
    base = corners[1] - corners[2]
    inward = np.array([-base[1], base[0]]) / np.linalg.norm(base)
    target = MESH.positions.copy()
    target[sliver[0]] += 1.2 * np.sign(inward @ (corners[1] - corners[0])) * areas.min() / np.linalg.norm(base) * inward
    corrected = untangle(target, MESH)
    assert corrected is not target
    assert np.abs(corrected - target).max() < 2 * areas.min() / np.linalg.norm(base)


def test_a_fold_changes_its_surroundings_only() -> None:
    target = MESH.positions.copy()
    target[0] += (0.2, 0.0)
    away = np.linalg.norm(MESH.positions - MESH.positions[0], axis=1) > 0.4
    np.testing.assert_allclose(untangle(target, MESH)[away], MESH.positions[away], atol=1e-3)
