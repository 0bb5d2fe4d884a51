import numpy as np
import pytest
from numpy.typing import NDArray

from conf.call.self_picture import ASPECT, SelfPicture
from conf.call.self_view import SelfView
from conf.receiver.panel_layout import Rect
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow
from conf.sender.capture.frame import Frame

pytestmark = pytest.mark.slow

RECT = Rect(20.0, 30.0, 96.0, 72.0)


def draw(
    window: OffscreenWindow, overlay: ImGuiOverlay, view: SelfView, *, is_drawn: bool = False
) -> NDArray[np.uint8]:
    picture = SelfPicture(window.ctx, view)
    window.begin()
    with overlay.frame(window, scale=0.8):
        picture.draw(overlay, RECT, "you", is_drawn=is_drawn)
    image = window.read()
    picture.release()
    return image


def test_the_camera_s_image_is_drawn_upright_as_in_a_mirror(window: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    pixels = np.zeros((48, 64, 3), np.uint8)
    pixels[:24, :32] = (255, 0, 0)  # blue at the upper left, as the camera sees it
    pixels[24:, 32:] = (0, 0, 255)  # red at the lower right
    view = SelfView()
    view.show(Frame(pixels, 0.0), None)
    image = draw(window, overlay, view).astype(int)
    upper, middle = 30 + 18, 20 + 48
    assert image[upper, middle + 24, 0] > 200 and image[upper, middle + 24, 2] < 50
    assert image[30 + 48, 20 + 20, 2] > 200 and image[30 + 48, 20 + 20, 0] < 50
    assert image[upper, middle - 24].max() < 50
    image[29:104, 19:118] = 0
    assert not image.any()


def test_without_an_image_the_place_is_empty_and_a_face_that_is_there_stays(
    window: OffscreenWindow, overlay: ImGuiOverlay
) -> None:
    view = SelfView()
    assert 0 < draw(window, overlay, view)[60, 60].max() < 60
    assert draw(window, overlay, view, is_drawn=True)[50, 60].max() == 0


def test_the_shape_is_that_of_the_camera_also_when_it_is_off(window: OffscreenWindow) -> None:
    view = SelfView()
    picture = SelfPicture(window.ctx, view)
    assert picture.aspect == ASPECT
    view.show(Frame(np.zeros((100, 50, 3), np.uint8), 0.0), None)
    assert picture.aspect == 0.5
    view.clear()
    assert picture.aspect == 0.5
    picture.release()


def test_a_new_image_replaces_the_old_and_its_size(window: OffscreenWindow, overlay: ImGuiOverlay) -> None:
    view = SelfView()
    picture = SelfPicture(window.ctx, view)
    for size, shade in (((48, 64), 255), ((48, 64), 90), ((24, 24), 180)):
        view.show(Frame(np.full((*size, 3), shade, np.uint8), 0.0), None)
        window.begin()
        with overlay.frame(window, scale=0.8):
            picture.draw(overlay, RECT, "you", is_drawn=False)
        assert abs(int(window.read()[50, 60, 1]) - shade) < 4
    picture.release()
