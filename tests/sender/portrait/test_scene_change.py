import numpy as np
import pytest

from conf.face.head_pose import HeadPose
from conf.face.portrait.warp import PortraitWarp
from conf.sender.portrait.scene_change import (
    LIGHT_SAMPLES,
    POSE_SAMPLES,
    SAMPLE_INTERVAL_S,
    SceneChangeDetector,
    angle_between,
)
from tests.support.portrait_subjects import motion, shaded_person
from tests.support.synthetic_portrait import POSE, face_shape

TURNED = HeadPose(POSE.rotation + np.array([0, 0.6, 0]), POSE.position, POSE.log_scale)
DARK = (0.6, 0.6, 0.6)


class Camera:
    def __init__(self) -> None:
        self.detector = SceneChangeDetector(PortraitWarp(face_shape()), shaded_person())
        self.now = 0.0

    def sample(self, count: int, tint: tuple[float, float, float] = (1, 1, 1), pose: HeadPose = POSE) -> bool:
        """Take samples and return whether the scene has changed; tint : factors of blue, green and red."""
        pixels = np.clip(shaded_person() * tint, 0, 255).astype(np.uint8)
        for _ in range(count):
            self.detector.sample(pixels, motion(pose=pose), self.now)
            self.now += SAMPLE_INTERVAL_S
        return self.detector.changed


@pytest.mark.slow
@pytest.mark.parametrize("tint", [(0.7, 0.7, 0.7), (0.65, 0.9, 1.1)])
def test_other_light_counts_once_most_samples_show_it(tint: tuple[float, float, float]) -> None:
    camera = Camera()
    assert not camera.sample(LIGHT_SAMPLES)
    assert not camera.sample(LIGHT_SAMPLES // 2 - 1, tint)
    assert camera.sample(LIGHT_SAMPLES // 2 + 1, tint)


@pytest.mark.slow
def test_slightly_less_light_does_not_count() -> None:
    assert not Camera().sample(4 * LIGHT_SAMPLES, (0.93, 0.93, 0.93))


@pytest.mark.slow
def test_flickering_light_does_not_count() -> None:
    camera = Camera()
    assert not any(camera.sample(2, DARK) or camera.sample(2) for _ in range(10))


@pytest.mark.slow
@pytest.mark.parametrize(
    "pose",
    [
        HeadPose(POSE.rotation, POSE.position + np.array([0.3, 0.0]), POSE.log_scale),
        HeadPose(POSE.rotation, POSE.position, POSE.log_scale + 0.5),
        TURNED,
    ],
    ids=["moved", "nearer", "turned"],
)
def test_another_head_position_counts_if_it_stays(pose: HeadPose) -> None:
    camera = Camera()
    camera.sample(POSE_SAMPLES)
    assert not camera.sample(5, pose=pose)
    assert camera.sample(POSE_SAMPLES, pose=pose)


@pytest.mark.slow
def test_samples_are_taken_twice_a_second_at_any_frame_rate() -> None:
    camera = Camera()
    for _ in range(200):
        camera.detector.sample(shaded_person(0.5), motion(), 0.0)
    assert not camera.detector.changed


def test_the_angle_between_two_heads() -> None:
    assert angle_between(POSE, TURNED) == pytest.approx(0.6, abs=0.02)
