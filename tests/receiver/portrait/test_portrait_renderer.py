from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX, control_point_indices
from conf.face.head_pose import HeadPose
from conf.face.portrait.patch_features import MOUTH
from conf.protocol.portrait.background import Background
from conf.protocol.portrait.objects import encode_object
from conf.receiver.portrait.portrait_renderer import PortraitRenderer, TexturedLayer, load_texture
from conf.receiver.portrait.portrait_store import PortraitStore
from conf.render.camera import ViewState
from conf.render.shader_programs import load_program
from conf.render.window.offscreen import OffscreenWindow
from tests.support.drawn_person import SIZE, draw_person, encode_vp8, make_patch, make_photo, make_view, to_pixels
from tests.support.synthetic_portrait import POSE

pytestmark = pytest.mark.slow

STILL = np.zeros((CONTROL_POINT_COUNT, 3))
AHEAD = ViewState()


class Scene:
    """A portrait store, its renderer and a window."""

    def __init__(self, size: tuple[int, int]) -> None:
        self.store = PortraitStore()
        self.window = OffscreenWindow(*size)
        self.window.begin()
        self.renderer = PortraitRenderer(self.window.ctx, self.store)

    def draw(
        self, displacements: NDArray[np.float64] = STILL, pose: HeadPose = POSE, view: ViewState = AHEAD
    ) -> NDArray[np.uint8]:
        self.window.begin()
        self.renderer.draw(displacements, pose, view, self.window.framebuffer)
        return self.window.read()


def scene_with_photo(size: tuple[int, int] = SIZE) -> Iterator[Scene]:
    scene = Scene(size)
    scene.store.receive(encode_object(make_photo()))
    yield scene
    scene.renderer.release()
    scene.window.release()


@pytest.mark.usefixtures("gl")
def test_the_portrait_of_the_photographed_expression_resembles_the_photo() -> None:
    for scene in scene_with_photo():
        assert np.abs(scene.draw().astype(float) - draw_person()).mean() < 3


@pytest.mark.usefixtures("gl")
def test_the_person_moves_and_the_background_does_not() -> None:
    for scene in scene_with_photo():
        still = scene.draw().astype(int)
        moved = scene.draw(pose=replace(POSE, position=POSE.position + np.array((0.08, 0.0)))).astype(int)
        shift = np.rint(to_pixels(np.array([[0.08, 0.0]]))[0] - to_pixels(np.zeros((1, 2)))[0]).astype(int)
        assert np.abs(still[:, :40] - moved[:, :40]).max() <= 2
        face = still[70:140, 130:190]
        assert np.abs(face - moved[70 + shift[1] : 140 + shift[1], 130 + shift[0] : 190 + shift[0]]).mean() < 6


@pytest.mark.usefixtures("gl")
def test_the_viewers_orbit_is_limited() -> None:
    for scene in scene_with_photo():
        front, rotated = scene.draw().astype(int), scene.draw(view=ViewState(yaw=0.3)).astype(int)
        assert np.abs(front - rotated)[60:150, 120:210].mean() > 2
        np.testing.assert_array_equal(scene.draw(view=ViewState(yaw=1.0)), scene.draw(view=ViewState(yaw=40.0)))


@pytest.mark.usefixtures("gl")
def test_a_patch_with_a_near_descriptor_is_drawn_in_its_region_only() -> None:
    for scene in scene_with_photo():
        smile = STILL.copy()
        smile[CONTROL_POINT_INDEX["outer_lip_corner_l"], :2] = (200, 200)
        smile[CONTROL_POINT_INDEX["outer_lip_corner_r"], :2] = (-200, 200)
        before, still = scene.draw(smile).astype(int), scene.draw().astype(int)
        scene.store.receive(encode_object(replace(make_patch(), descriptor=MOUTH.quantised_descriptor(smile))))
        after = scene.draw(smile).astype(int)
        assert np.abs(scene.draw().astype(int) - still).max() < 10
        difference = np.abs(after - before).max(axis=2)
        x, y = np.rint(to_pixels(np.array([POSE.position]))[0]).astype(int)
        assert difference[y + 25 : y + 45, x - 15 : x + 15].max() > 40
        assert difference[: y - 10].max() <= 2


@pytest.mark.usefixtures("gl")
def test_noise_around_the_photographed_expression_does_not_blend_in_a_patch() -> None:
    for scene in scene_with_photo():
        assert scene.store.photo is not None
        photo_displacements = scene.store.photo.warp.photo_displacements()
        noisy = photo_displacements.copy()
        noisy[CONTROL_POINT_INDEX["outer_lip_corner_l"], :2] += (40, 40)
        poses = (POSE, replace(POSE, rotation=POSE.rotation + np.array((0.0, 0.2, 0.0))))
        before = [scene.draw(noisy, pose).astype(int) for pose in poses]
        descriptor = MOUTH.quantised_descriptor(photo_displacements + 3 * (noisy - photo_displacements))
        scene.store.receive(encode_object(replace(make_patch(), descriptor=descriptor)))
        still, rotated = (
            np.abs(scene.draw(noisy, pose) - image).max() for pose, image in zip(poses, before, strict=True)
        )
        assert still < 10 < 20 < rotated


@pytest.mark.usefixtures("gl")
def test_an_open_mouth_without_a_matching_patch_has_teeth_above_a_dark_gap() -> None:
    for scene in scene_with_photo():
        opened = STILL.copy()
        opened[control_point_indices("inner_lip_lower", "outer_lip_lower", "chin"), 1] = -800
        assert scene.store.photo is not None
        points = scene.store.photo.warp.deform(opened, POSE)
        lips = points[[CONTROL_POINT_INDEX["inner_lip_upper_mid"], CONTROL_POINT_INDEX["inner_lip_lower_mid"]]]
        x, y = np.rint(to_pixels(lips.mean(axis=0)[None])[0]).astype(int)
        top = round(to_pixels(lips[:1])[0, 1])
        for _ in range(2):
            image = scene.draw(opened).astype(int)
            assert image[top + 2 : y, x].min(axis=1).max() > 90 > 80 > image[y : y + 4, x].min(axis=1).min()
            scene.store.receive(encode_object(make_patch(slot=1)))  # of a mouth that was less open


@pytest.mark.usefixtures("gl")
@pytest.mark.parametrize("size", [(640, 240), (240, 480)])
def test_a_viewport_of_another_aspect_ratio_has_dark_borders(size: tuple[int, int]) -> None:
    for scene in scene_with_photo(size):
        image = scene.draw()
        assert image[size[1] // 2, size[0] // 2].max() > 60
        assert image[0, 0].max() < 60 and image[-1, -1].max() < 60


@pytest.mark.usefixtures("gl")
def test_nothing_is_drawn_outside_the_viewport() -> None:
    for scene in scene_with_photo((320, 120)):
        scene.window.begin()
        scene.window.framebuffer.viewport = (0, 0, 160, 120)
        scene.renderer.draw(STILL, POSE, ViewState(), scene.window.framebuffer)
        scene.window.framebuffer.viewport = (0, 0, 320, 120)
        assert scene.window.read()[:, 160:].max() == 0


@pytest.mark.usefixtures("gl")
def test_drawing_without_a_photo_is_an_error() -> None:
    scene = Scene((32, 32))
    assert not scene.renderer.ready
    with pytest.raises(ValueError, match="the store must have a photo"):
        scene.draw()
    scene.renderer.release()
    scene.window.release()


@pytest.mark.usefixtures("gl")
def test_the_first_row_of_a_texture_is_drawn_at_the_top() -> None:
    pixels = np.zeros((2, 1, 3), np.uint8)
    pixels[0], pixels[1] = (255, 0, 0), (0, 0, 255)  # blue above red
    with OffscreenWindow(8, 8) as window:
        window.begin()
        program = load_program(window.ctx, "portrait", "portrait")
        program["frame"], program["opacity"], program["fade"] = (1.0, 1.0, 0.0, 0.0), 1.0, 0.0
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], np.float32)
        layer = TexturedLayer(
            window.ctx, program, window.ctx.buffer(corners.tobytes()), uvs=corners * (0.5, -0.5) + 0.5,
            alphas=np.ones(4), triangles=np.array([[0, 1, 2], [0, 2, 3]]), texture=load_texture(window.ctx, pixels),
        )  # fmt: skip
        layer.draw()
        image = window.read()
        layer.release()
    np.testing.assert_array_equal(image[0, 4], (255, 0, 0))
    np.testing.assert_array_equal(image[-1, 4], (0, 0, 255))


@pytest.mark.usefixtures("gl")
def test_a_view_is_shown_in_its_pose_and_hardly_in_the_photos() -> None:
    turned = HeadPose(POSE.rotation + np.array([0.0, 0.35, 0.0]), POSE.position, POSE.log_scale)
    for scene in scene_with_photo():
        x, y = np.rint(to_pixels(POSE.position[None])[0]).astype(int)
        before = scene.draw().astype(int)
        scene.store.receive(encode_object(make_view(pose=turned, colour=(0, 255, 0))))
        assert np.abs(scene.draw()[y, x].astype(int) - before[y, x]).max() < 40
        blue, green, red = scene.draw(pose=turned)[y, x].astype(int)
        assert green > 200 and max(blue, red) < 60, "the view's colour"
        np.testing.assert_array_equal(scene.draw()[:20, :20], before[:20, :20])
        scene.store.views.clear()
        np.testing.assert_array_equal(scene.draw(), before)


@pytest.mark.usefixtures("gl")
def test_a_mouth_that_a_view_shows_is_neither_predicted_nor_covered_by_a_patch_of_another() -> None:
    for scene in scene_with_photo():
        opened = STILL.copy()
        opened[control_point_indices("inner_lip_lower", "outer_lip_lower", "chin"), 1] = -800
        assert scene.store.photo is not None
        points = scene.store.photo.warp.control_points(opened)
        scene.store.receive(encode_object(make_patch(slot=1)))  # of a mouth that is nearly shut
        scene.store.receive(encode_object(replace(make_view(colour=(0, 255, 0)), points=points)))
        lips = [CONTROL_POINT_INDEX["inner_lip_upper_mid"], CONTROL_POINT_INDEX["inner_lip_lower_mid"]]
        x, y = np.rint(to_pixels(scene.store.photo.warp.deform(opened, POSE)[lips].mean(axis=0)[None])[0]).astype(int)
        blue, green, red = scene.draw(opened)[y, x].astype(int)
        assert green > 200 and max(blue, red) < 60, "the view's colour"


@pytest.mark.usefixtures("gl")
def test_a_background_that_arrives_later_is_drawn_where_the_head_was() -> None:
    aside = replace(POSE, position=POSE.position + np.array((0.3, 0.0)))
    for scene in scene_with_photo():
        x, y = np.rint(to_pixels(POSE.position[None])[0]).astype(int)
        before = scene.draw(pose=aside).astype(int)
        green = encode_vp8(np.full((48, 64, 3), (0, 200, 0), np.uint8))
        scene.store.receive(encode_object(Background(1, (0.2, 0.1, 0.8, 0.9), green)))
        after = scene.draw(pose=aside).astype(int)
        assert np.abs(after[y, x - 40] - (0, 200, 0)).max() < 30 < np.abs(before[y, x - 40] - (0, 200, 0)).max()
        np.testing.assert_array_equal(after[:, :30], before[:, :30])
