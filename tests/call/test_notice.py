import pytest

from conf.call.notice import draw_notice, notice_size
from conf.call.view import Notice
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow

pytestmark = pytest.mark.slow

WAITING = Notice("waiting for a call at 10.0.0.1:5005", "acorn-tulip-river-42", ("Ann has hung up",))


@pytest.mark.parametrize("notice", [WAITING, Notice("calling 10.0.0.1:5005")])
@pytest.mark.parametrize("size", [(1280, 720), (420, 300)])
def test_the_notice_fits_its_rectangle_and_the_window(gl: None, notice: Notice, size: tuple[int, int]) -> None:
    with OffscreenWindow(*size) as window, ImGuiOverlay(window.ctx) as overlay:
        window.begin()
        with overlay.frame(window):
            width, height = notice_size(overlay, notice)
            draw_notice(overlay, notice, (10.0, 20.0))
        painted = window.read().max(axis=2)
    assert width < size[0] and height < size[1]
    assert painted[round(20 + height / 2), round(10 + width / 2) - 20 : round(10 + width / 2) + 20].any()
    painted[19 : round(20 + height) + 1, 9 : round(10 + width) + 1] = 0
    assert not painted.any()


def test_the_code_is_larger_than_the_rest(gl: None) -> None:
    with OffscreenWindow(1280, 720) as window, ImGuiOverlay(window.ctx) as overlay:
        with overlay.frame(window):
            plain = notice_size(overlay, Notice("title", "", ("acorn-tulip-river-42",)))
            large = notice_size(overlay, Notice("title", "acorn-tulip-river-42"))
    assert large[0] > 2 * plain[0] and large[1] > plain[1]
