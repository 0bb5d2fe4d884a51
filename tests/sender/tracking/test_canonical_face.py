import numpy as np
import pytest

from conf.face.head_pose import HeadPose
from conf.sender.tracking.canonical_face import FLIP, CanonicalFace, remove_head_pose


def test_the_canonical_face_is_symmetric_and_in_centimetres(canonical: CanonicalFace) -> None:
    assert canonical.vertices.shape == (468, 3)
    assert canonical.triangles.shape == (898, 3)
    assert canonical.triangles.min() == 0
    assert canonical.triangles.max() == 467
    eyes = (canonical.vertices[[33, 133]].mean(axis=0), canonical.vertices[[263, 362]].mean(axis=0))
    assert np.linalg.norm(eyes[1] - eyes[0]) == pytest.approx(6.30, abs=0.01)
    assert eyes[1][0] > 0  # the subject's left is on +x
    assert canonical.vertices[10, 1] > canonical.vertices[152, 1]  # the forehead is above the chin
    assert np.allclose(canonical.vertices[33] * [-1, 1, 1], canonical.vertices[263])
    assert len(canonical.rigid) == 33
    assert canonical.weights.sum() == pytest.approx(1.055, abs=0.001)


def _posed(canonical: CanonicalFace, pose: HeadPose, size: tuple[int, int]) -> np.ndarray:
    """Return the landmarks of the canonical face in a pose, by the definition in head_pose."""
    width, height = size
    image = np.exp(pose.log_scale) * canonical.vertices @ pose.matrix().T
    image[:, :2] += pose.position
    landmarks = np.zeros((478, 3))
    landmarks[:468] = image * height * FLIP
    landmarks[:, :2] += [width / 2, height / 2]
    return landmarks


@pytest.mark.parametrize("size", [(320, 240), (176, 144), (480, 640)])
def test_pose_and_face_are_separated(canonical: CanonicalFace, size: tuple[int, int]) -> None:
    pose = HeadPose(np.array([0.1, -0.4, 0.2]), np.array([0.15, -0.1]), float(np.log(0.04)))
    aligned, found = remove_head_pose(_posed(canonical, pose, size), canonical, size)
    assert np.allclose(aligned[:468], canonical.vertices, atol=1e-9)
    assert np.allclose(found.to_vector(), pose.to_vector(), atol=1e-12)


def test_the_axes_are_those_of_head_pose(canonical: CanonicalFace) -> None:
    straight = np.zeros((478, 3))
    straight[:468] = canonical.vertices * FLIP * 10 + [100, 50, 0]
    aligned, pose = remove_head_pose(straight, canonical, (200, 200))
    assert np.allclose(pose.rotation, 0, atol=1e-9)
    assert np.allclose(pose.position, [0, 0.25])  # 50 px above the middle of 200
    assert np.exp(pose.log_scale) == pytest.approx(10 / 200)
    assert aligned[263, 0] > 0 > aligned[33, 0]
