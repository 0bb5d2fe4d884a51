import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.portrait.background import encode_background
from conf.sender.portrait.background_learning import MAX_BYTES, MIN_COUNT, BackgroundLearner
from conf.sender.portrait.photo_builder import decode_vp8
from conf.sender.portrait.recent_frames import RecentFrame
from tests.support.drawn_person import SIZE, draw_person
from tests.support.portrait_subjects import motion, recent_frame
from tests.support.synthetic_portrait import POSE, face_shape

pytestmark = pytest.mark.slow

SHIFT_PX = 72
DOOR = (20, 30, 90)  # BGR: the person in the photo covers it
DOOR_AREA = (slice(80, 150), slice(175, 210))


def scene(shift_px: int = 0, *, light: float = 1.0, door: tuple[int, int, int] = DOOR) -> NDArray[np.uint8]:
    """Return the person, moved to the left, before a wall with a door."""
    pixels = np.roll(draw_person(), -shift_px, axis=1)
    wall = (pixels[DOOR_AREA] == draw_person()[5, 5]).all(axis=2)
    pixels[DOOR_AREA][wall] = door
    return np.clip(pixels * light, 0, 255).astype(np.uint8)


def moved(pixels: NDArray[np.uint8], shift_px: int = SHIFT_PX) -> RecentFrame:
    position = POSE.position - (shift_px / SIZE[1], 0.0)
    return recent_frame(pixels, motion(pose=HeadPose(POSE.rotation, position, POSE.log_scale)))


def learner() -> BackgroundLearner:
    return BackgroundLearner(PortraitWarp(face_shape()), scene(), 7)


def test_what_a_moved_person_uncovers_is_learned_once_and_sent_in_few_bytes() -> None:
    learning = learner()
    for _ in range(MIN_COUNT):
        assert not learning.is_worth_sending
        learning.sample(moved(scene(SHIFT_PX)))
    assert learning.is_worth_sending
    background = learning.build()
    assert not learning.is_worth_sending
    assert background.photo_number == 7 and len(encode_background(background)) <= MAX_BYTES + 20
    left, top, right, bottom = background.box
    assert 0.38 < left < right <= 0.95 and top < bottom
    image = decode_vp8(background.frame)
    height, width = image.shape[:2]
    y, x = (115 / SIZE[1] - top) / (bottom - top) * height, (192 / SIZE[0] - left) / (right - left) * width
    assert np.abs(image[int(y), int(x)].astype(int) - DOOR).max() < 40


def test_a_person_who_stays_teaches_nothing() -> None:
    learning = learner()
    for _ in range(3 * MIN_COUNT):
        learning.sample(moved(scene(), 0))
    assert not learning.is_worth_sending


@pytest.mark.parametrize("light", [0.7, 1.3])
def test_another_light_or_another_view_of_the_room_teaches_nothing(light: float) -> None:
    learning = learner()
    for _ in range(3 * MIN_COUNT):
        learning.sample(moved(scene(SHIFT_PX, light=light)))
    assert not learning.is_worth_sending


def test_what_looks_different_in_every_frame_is_not_learned() -> None:
    learning = learner()
    for number in range(3 * MIN_COUNT):
        learning.sample(moved(scene(SHIFT_PX, door=(20 + 60 * (number % 3), 30, 90))))
    assert not learning.is_worth_sending


def test_a_plain_wall_is_not_sent_because_the_receiver_interpolates_it() -> None:
    learning = BackgroundLearner(PortraitWarp(face_shape()), draw_person(), 7)
    for _ in range(3 * MIN_COUNT):
        learning.sample(moved(np.roll(draw_person(), -SHIFT_PX, axis=1)))
    assert not learning.is_worth_sending
