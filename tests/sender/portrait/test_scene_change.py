import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.face.portrait.warp import PortraitWarp
from conf.sender.portrait.scene_change import EVERY_S, LIGHT_SAMPLES, PLACE_LOOKS, SceneChangeDetector
from tests.sender.portrait.test_occlusion import shaded
from tests.support.portrait_subjects import motion
from tests.support.synthetic_portrait import POSE, face_shape


class Camera:
    def __init__(self) -> None:
        self.view = SceneChangeDetector(PortraitWarp(face_shape()), shaded())
        self.now = 0.0

    def look(self, looks: int, tint: tuple[float, float, float] = (1, 1, 1), pose: HeadPose = POSE) -> bool:
        """Look so many times; tint : what becomes of blue, green and red."""
        pixels: NDArray[np.uint8] = np.clip(shaded() * tint, 0, 255).astype(np.uint8)
        for _ in range(looks):
            self.view.sample(pixels, motion(pose=pose), self.now)
            self.now += EVERY_S
        return self.view.changed


def test_another_lamp_counts_once_it_has_stayed() -> None:
    for tint in ((0.7, 0.7, 0.7), (0.65, 0.9, 1.1)):
        camera = Camera()
        assert not camera.look(LIGHT_SAMPLES)
        assert not camera.look(LIGHT_SAMPLES // 2 - 1, tint)
        assert camera.look(LIGHT_SAMPLES // 2 + 1, tint)


def test_a_little_less_light_does_not_count() -> None:
    assert not Camera().look(4 * LIGHT_SAMPLES, (0.93, 0.93, 0.93))


def test_light_that_comes_and_goes_does_not_count() -> None:
    camera = Camera()
    assert not any(camera.look(2, (0.6, 0.6, 0.6)) or camera.look(2) for _ in range(10))


def test_a_head_that_stays_elsewhere_counts_and_a_lean_does_not() -> None:
    elsewhere = HeadPose(POSE.rotation, POSE.position + np.array([0.3, 0.0]), POSE.log_scale)
    nearer = HeadPose(POSE.rotation, POSE.position, POSE.log_scale + 0.5)
    turned = HeadPose(POSE.rotation + np.array([0, 0.6, 0]), POSE.position, POSE.log_scale)
    for pose in (elsewhere, nearer, turned):
        camera = Camera()
        camera.look(PLACE_LOOKS)
        assert not camera.look(5, pose=pose)
        assert camera.look(PLACE_LOOKS, pose=pose)


def test_it_looks_twice_a_second_however_often_it_is_asked() -> None:
    camera = Camera()
    dark = (shaded() * 0.5).astype(np.uint8)
    for _ in range(200):
        camera.view.sample(dark, motion(), 0.0)
    assert not camera.view.changed
