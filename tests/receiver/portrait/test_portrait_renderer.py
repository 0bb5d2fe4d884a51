from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.head_pose import HeadPose
from conf.face.portrait.patch_features import MOUTH
from conf.protocol.portrait import encode_object
from conf.receiver.portrait.portrait_renderer import PortraitRenderer
from conf.receiver.portrait.portrait_store import PortraitStore
from conf.render.camera import ViewState
from conf.render.window.offscreen import OffscreenWindow
from tests.support.drawn_person import SIZE, draw_person, patch, photograph, to_pixels
from tests.support.synthetic_portrait import POSE

STILL = np.zeros((CONTROL_POINT_COUNT, 3))
AHEAD = ViewState()


class Easel:
    """An album, its renderer and a window."""

    def __init__(self, size: tuple[int, int]) -> None:
        self.album = PortraitStore()
        self.window = OffscreenWindow(*size)
        self.window.begin()
        self.renderer = PortraitRenderer(self.window.ctx, self.album)

    def draw(
        self, displacements: NDArray[np.float64] = STILL, pose: HeadPose = POSE, view: ViewState = AHEAD
    ) -> NDArray[np.uint8]:
        self.window.begin()
        self.renderer.draw(displacements, pose, view, self.window.framebuffer)
        return self.window.read()


def easel(size: tuple[int, int] = SIZE) -> Iterator[Easel]:
    made = Easel(size)
    made.album.receive(encode_object(photograph()))
    yield made
    made.renderer.release()
    made.window.release()


@pytest.mark.usefixtures("gl")
def test_the_photograph_shows_itself() -> None:
    for made in easel():
        assert np.abs(made.draw().astype(float) - draw_person()).mean() < 3


@pytest.mark.usefixtures("gl")
def test_the_person_moves_and_the_background_stays() -> None:
    for made in easel():
        still = made.draw().astype(int)
        moved = made.draw(pose=replace(POSE, position=POSE.position + np.array((0.08, 0.0)))).astype(int)
        eye = np.rint(to_pixels(np.array([[0.08, 0.0]]))[0] - to_pixels(np.zeros((1, 2)))[0]).astype(int)
        assert np.abs(still[:, :40] - moved[:, :40]).max() <= 2
        face = still[70:140, 130:190]
        assert np.abs(face - moved[70 + eye[1] : 140 + eye[1], 130 + eye[0] : 190 + eye[0]]).mean() < 6


@pytest.mark.usefixtures("gl")
def test_the_hand_turns_the_face_a_little_and_never_farther() -> None:
    for made in easel():
        front, turned = made.draw().astype(int), made.draw(view=ViewState(yaw=0.3)).astype(int)
        assert np.abs(front - turned)[60:150, 120:210].mean() > 2
        np.testing.assert_array_equal(made.draw(view=ViewState(yaw=1.0)), made.draw(view=ViewState(yaw=40.0)))


@pytest.mark.usefixtures("gl")
def test_a_patch_shows_when_its_keys_are_near_and_only_at_its_place() -> None:
    for made in easel():
        smile = STILL.copy()
        smile[CONTROL_POINT_INDEX["outer_lip_corner_l"], :2] = (200, 200)
        smile[CONTROL_POINT_INDEX["outer_lip_corner_r"], :2] = (-200, 200)
        before, still = made.draw(smile).astype(int), made.draw().astype(int)
        made.album.receive(encode_object(replace(patch(), descriptor=MOUTH.quantised_descriptor(smile))))
        after = made.draw(smile).astype(int)
        assert np.abs(made.draw().astype(int) - still).max() < 10
        far = np.abs(after - before).max(axis=2)
        x, y = np.rint(to_pixels(np.array([POSE.position]))[0]).astype(int)
        assert far[y + 25 : y + 45, x - 15 : x + 15].max() > 40
        assert far[: y - 10].max() <= 2


@pytest.mark.usefixtures("gl")
def test_a_face_that_is_as_photographed_shows_the_photograph_though_a_patch_be_near() -> None:
    for made in easel():
        assert made.album.photo is not None
        photographed = made.album.photo.warp.photo_displacements()
        trembling = photographed.copy()
        trembling[CONTROL_POINT_INDEX["outer_lip_corner_l"], :2] += (40, 40)
        poses = (POSE, replace(POSE, rotation=POSE.rotation + np.array((0.0, 0.2, 0.0))))
        before = [made.draw(trembling, pose).astype(int) for pose in poses]
        keys = MOUTH.quantised_descriptor(photographed + 3 * (trembling - photographed))
        made.album.receive(encode_object(replace(patch(), descriptor=keys)))
        still, turned = (
            np.abs(made.draw(trembling, pose) - picture).max() for pose, picture in zip(poses, before, strict=True)
        )
        assert still < 10 < 20 < turned


@pytest.mark.usefixtures("gl")
def test_an_open_mouth_without_a_patch_is_dark() -> None:
    for made in easel():
        opened = STILL.copy()
        lips = [
            i
            for name, i in CONTROL_POINT_INDEX.items()
            if name.startswith(("inner_lip_lower", "outer_lip_lower", "chin"))
        ]
        opened[lips, 1] = -800
        points = made.album.photo.warp.deform(opened, POSE) if made.album.photo else STILL
        upper, lower = (
            points[CONTROL_POINT_INDEX["inner_lip_upper_mid"]],
            points[CONTROL_POINT_INDEX["inner_lip_lower_mid"]],
        )
        x, y = np.rint(to_pixels(((upper + lower) / 2)[None])[0]).astype(int)
        assert made.draw(opened)[y, x].max() < 90
        made.album.receive(
            encode_object(patch(slot=1))
        )  # of a mouth that was less open: darkened, not stretched bright
        assert made.draw(opened)[y, x].max() < 110


@pytest.mark.usefixtures("gl")
@pytest.mark.parametrize("size", [(640, 240), (240, 480)])
def test_a_window_of_another_shape_has_a_quiet_surround(size: tuple[int, int]) -> None:
    for made in easel(size):
        seen = made.draw()
        assert seen[size[1] // 2, size[0] // 2].max() > 60
        assert seen[0, 0].max() < 60 and seen[-1, -1].max() < 60


@pytest.mark.usefixtures("gl")
def test_a_cell_of_a_grid_leaves_the_others_alone() -> None:
    for made in easel((320, 120)):
        made.window.begin()
        made.window.framebuffer.viewport = (0, 0, 160, 120)
        made.renderer.draw(STILL, POSE, ViewState(), made.window.framebuffer)
        made.window.framebuffer.viewport = (0, 0, 320, 120)
        assert made.window.read()[:, 160:].max() == 0


@pytest.mark.usefixtures("gl")
def test_without_a_photograph_there_is_nothing_to_draw() -> None:
    made = Easel((32, 32))
    assert not made.renderer.ready
    with pytest.raises(ValueError, match="the album must have a photograph"):
        made.draw()
    made.renderer.release()
    made.window.release()
