import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from conf.face.head_pose import HeadPose
from conf.sender.canonical_face import CanonicalFace
from conf.sender.pose import FLIP, fit_similarity, remove_head_pose

vectors = hnp.arrays(np.float64, 3, elements=st.floats(-2, 2))


@given(vectors, st.floats(0.01, 100), vectors, st.integers(0, 1000))
def test_a_known_similarity_is_recovered(turn: np.ndarray, scale: float, shift: np.ndarray, seed: int) -> None:
    rng = np.random.default_rng(seed)
    source, weights = rng.normal(size=(12, 3)), rng.uniform(0.1, 1, 12)
    rotation = Rotation.from_rotvec(turn).as_matrix()
    fit = fit_similarity(source, scale * source @ rotation.T + shift, weights)
    assert np.allclose(fit.rotation, rotation, atol=1e-7)
    assert fit.scale == pytest.approx(scale, rel=1e-9)
    assert np.allclose(fit.translation, shift, atol=1e-7 * max(scale, 1))


@given(st.integers(0, 1000))
def test_no_other_turn_fits_noisy_points_better(seed: int) -> None:
    rng = np.random.default_rng(seed)
    source, target, weights = rng.normal(size=(8, 3)), rng.normal(size=(8, 3)), rng.uniform(0.1, 1, 8)
    fit = fit_similarity(source, target, weights)

    def error(rotation: np.ndarray, scale: float, shift: np.ndarray) -> float:
        return float(weights @ np.sum((scale * source @ rotation.T + shift - target) ** 2, axis=1))

    best = error(fit.rotation, fit.scale, fit.translation)
    assert np.linalg.det(fit.rotation) == pytest.approx(1)
    for _ in range(20):
        nudge = Rotation.from_rotvec(rng.normal(scale=0.05, size=3)).as_matrix()
        assert best <= error(nudge @ fit.rotation, fit.scale * rng.uniform(0.9, 1.1), fit.translation) + 1e-9


def _posed(canonical: CanonicalFace, pose: HeadPose, size: tuple[int, int]) -> np.ndarray:
    """Draw the canonical face as the tracker would see it: the inverse of what is tested, from head_pose's words."""
    width, height = size
    picture = np.exp(pose.log_scale) * canonical.vertices @ pose.matrix().T
    picture[:, :2] += pose.position
    landmarks = np.zeros((478, 3))
    landmarks[:468] = picture * height * FLIP
    landmarks[:, :2] += [width / 2, height / 2]
    return landmarks


@pytest.mark.parametrize("size", [(320, 240), (176, 144), (480, 640)])
def test_pose_and_face_come_apart_again(canonical: CanonicalFace, size: tuple[int, int]) -> None:
    pose = HeadPose(np.array([0.1, -0.4, 0.2]), np.array([0.15, -0.1]), float(np.log(0.04)))
    aligned, found = remove_head_pose(_posed(canonical, pose, size), canonical, size)
    assert np.allclose(aligned[:468], canonical.vertices, atol=1e-9)
    assert np.allclose(found.to_vector(), pose.to_vector(), atol=1e-12)


def test_directions_are_those_of_head_pose(canonical: CanonicalFace) -> None:
    straight = np.zeros((478, 3))
    straight[:468] = canonical.vertices * FLIP * 10 + [100, 50, 0]
    aligned, pose = remove_head_pose(straight, canonical, (200, 200))
    assert np.allclose(pose.rotation, 0, atol=1e-9)
    assert np.allclose(pose.position, [0, 0.25])  # 50 px above the middle of 200
    assert np.exp(pose.log_scale) == pytest.approx(10 / 200)
    assert aligned[263, 0] > 0 > aligned[33, 0]
