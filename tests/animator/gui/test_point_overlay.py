from collections.abc import Iterator

import numpy as np
import pytest

from conf.animator.face_view import FaceView
from conf.animator.gui.point_overlay import draw_control_points
from conf.animator.motion_player import REST_POSE
from conf.animator.state.editor import ViewSettings
from conf.animator.state.point_placement import PointPlacement
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel
from conf.render.camera import ViewState, clip_matrix
from conf.render.ui.imgui_overlay import ACCENT
from conf.render.ui.rectangle import Rect
from conf.render.ui.theme import GREEN
from tests.support.imgui_stage import Stage

RECT = Rect(0, 0, 400, 900)
CAMERA = ViewState(stats=False, yaw=1.2)  # hides the left cheek behind the face
LEFT, RIGHT = CONTROL_POINT_INDEX["cheekbone_l"], CONTROL_POINT_INDEX["cheekbone_r"]
CLIP = clip_matrix(REST_POSE, CAMERA, aspect=RECT.width / RECT.height)


class Overlay:
    """Draws the face with control points over it."""

    def __init__(self, stage: Stage, head: FaceModel) -> None:
        self._stage, self._head = stage, head
        self.view = FaceView(stage.window.ctx, head)

    def draw(self, placement: PointPlacement) -> tuple[np.ndarray, np.ndarray]:
        """Return the pixels of the points that can be grabbed, and the (H, W, 3) BGR image."""
        stage = self._stage
        for _ in range(2):  # ImGui rasterises new glyphs in the first frame
            stage.window.begin()
            self.view.draw(self._head.neutral, REST_POSE, ViewSettings(CAMERA), stage.window.framebuffer)
            with stage.overlay.frame(stage.window, scale=1.0):
                pixels = draw_control_points(stage.overlay, RECT, placement, self.view, CLIP)
        return pixels, stage.window.read()


@pytest.fixture
def overlay(stage: Stage, head: FaceModel) -> Iterator[Overlay]:
    overlay = Overlay(stage, head)
    yield overlay
    overlay.view.release()


def place(points: np.ndarray, *indices: int, selected: int) -> PointPlacement:
    placement = PointPlacement(selected=selected)
    for index in indices:
        placement = placement.set_point(index, points[index])
    return placement


def colour_at(image: np.ndarray, pixel: np.ndarray) -> np.ndarray:
    x, y = np.round(pixel).astype(int)
    return image[y, x, ::-1] / 255


@pytest.mark.slow
def test_without_points_nothing_is_drawn(overlay: Overlay, points: np.ndarray) -> None:
    pixels, image = overlay.draw(PointPlacement())
    assert np.isnan(pixels).all() and pixels.shape == (50, 2)
    outside = place(points, RIGHT, selected=0).set_point(RIGHT, np.array([500.0, 0.0, 0.0]))
    np.testing.assert_array_equal(overlay.draw(outside)[1], image, "clipped at the rectangle")


@pytest.mark.slow
def test_dots_lie_on_the_points_and_hidden_points_cannot_be_grabbed(overlay: Overlay, points: np.ndarray) -> None:
    pixels, image = overlay.draw(place(points, LEFT, RIGHT, selected=0))
    expected = RECT.to_pixels(points, CLIP)
    np.testing.assert_allclose(pixels[RIGHT], expected[RIGHT])
    assert np.isfinite(pixels[:, 0]).sum() == 1, "the left one is hidden, the others are not placed"
    np.testing.assert_allclose(colour_at(image, expected[RIGHT]), GREEN[:3], atol=0.02)
    assert np.abs(colour_at(image, expected[LEFT]) - GREEN[:3]).max() > 0.1, "faint behind the face"


@pytest.mark.slow
def test_the_selected_point_is_highlighted_numbered_and_can_be_grabbed_when_hidden(
    overlay: Overlay, points: np.ndarray
) -> None:
    expected = RECT.to_pixels(points, CLIP)
    _, plain = overlay.draw(place(points, LEFT, selected=0))
    pixels, image = overlay.draw(place(points, LEFT, selected=LEFT))
    np.testing.assert_allclose(pixels[LEFT], expected[LEFT])
    np.testing.assert_allclose(colour_at(image, expected[LEFT]), ACCENT[:3], atol=0.02)
    x, y = np.round(expected[LEFT]).astype(int)
    number = np.s_[y - 7 : y + 8, x + 9 : x + 25]
    assert (plain[number] != image[number]).any(axis=2).sum() > 20
