import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from conf.face.portrait.photo_mesh import build_mesh, signed_areas
from conf.face.portrait.untangle import untangle
from tests.support.synthetic_portrait import face_shape

MESH = build_mesh(face_shape())


@given(st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_nothing_is_turned_over_whatever_the_target(seed: int, wildness: float) -> None:
    rng = np.random.default_rng(seed)
    target = MESH.positions + 0.3 * wildness * rng.normal(size=2) + wildness * rng.normal(size=MESH.positions.shape)
    assert signed_areas(untangle(target, MESH), MESH.triangles).min() > 0


def test_what_does_not_fold_stays_as_it_is() -> None:
    target = MESH.positions * 1.1 + 0.02
    assert untangle(target, MESH) is target


def test_a_sliver_that_folds_costs_its_corners_little() -> None:
    areas = signed_areas(MESH.positions, MESH.triangles)
    sliver = MESH.triangles[np.argmin(areas)]
    corners = MESH.positions[sliver]
    base = corners[1] - corners[2]
    inward = np.array([-base[1], base[0]]) / np.linalg.norm(base)
    target = MESH.positions.copy()
    target[sliver[0]] += 1.2 * np.sign(inward @ (corners[1] - corners[0])) * areas.min() / np.linalg.norm(base) * inward
    unfolded = untangle(target, MESH)
    assert unfolded is not target
    assert np.abs(unfolded - target).max() < 2 * areas.min() / np.linalg.norm(base)


def test_a_fold_holds_back_what_is_around_it_and_nothing_else() -> None:
    target = MESH.positions.copy()
    target[0] += (0.2, 0.0)
    away = np.linalg.norm(MESH.positions - MESH.positions[0], axis=1) > 0.4
    np.testing.assert_allclose(untangle(target, MESH)[away], MESH.positions[away], atol=1e-3)
