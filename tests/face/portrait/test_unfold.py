import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from conf.face.portrait.mesh import build_mesh, signed_areas
from conf.face.portrait.unfold import unfold
from tests.face.portrait.synthetic import face_shape

MESH = build_mesh(face_shape())


@given(st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_nothing_is_turned_over_whatever_the_target(seed: int, wildness: float) -> None:
    rng = np.random.default_rng(seed)
    still = MESH.places + 0.3 * wildness * rng.normal(size=2)
    target = still + wildness * rng.normal(size=MESH.places.shape)
    assert signed_areas(unfold(target, still, MESH), MESH.triangles).min() > 0


def test_what_does_not_fold_stays_as_it_is() -> None:
    target = MESH.places * 1.1 + 0.02
    assert unfold(target, MESH.places, MESH) is target


def test_a_fold_holds_back_what_is_around_it_and_nothing_else() -> None:
    target = MESH.places.copy()
    target[0] += (0.2, 0.0)
    away = np.linalg.norm(MESH.places - MESH.places[0], axis=1) > 0.4
    np.testing.assert_allclose(unfold(target, MESH.places, MESH)[away], MESH.places[away])
