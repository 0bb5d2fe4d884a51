import numpy as np
import pytest

from conf.face.head_pose import HeadPose
from conf.sender.tracking.canonical_face import CanonicalFace
from conf.sender.tracking.pose_removal import FLIP, remove_head_pose


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
