import moderngl
import numpy as np
import pytest

from conf.errors import GraphicsError
from conf.render.window.offscreen import OffscreenWindow
from tests.support.stand_in_head import SIZE


def test_read_returns_bgr_with_the_first_row_on_top(window: OffscreenWindow) -> None:
    window.begin()
    window.framebuffer.clear(1.0, 0.5, 0.0, viewport=(0, SIZE[1] - 10, SIZE[0], 10))
    window.end()
    pixels = window.read()
    assert pixels.shape == (SIZE[1], SIZE[0], 3) and pixels.dtype == np.uint8
    assert pixels[:10].reshape(-1, 3).tolist() == [[0, 128, 255]] * (10 * SIZE[0])
    assert not pixels[10:].any()


def test_waiting_for_what_is_drawn_does_not_hold_pythons_lock_as_moderngl_does(
    window: OffscreenWindow, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(moderngl.Context, "finish", lambda _: pytest.fail("moderngl's finish"))
    window.begin()
    window.framebuffer.clear(0.0, 0.0, 1.0)
    window.finish()
    assert window.read()[0, 0].tolist() == [255, 0, 0]


def test_without_a_loader_of_opengl_functions_it_waits_as_moderngl_does(
    window: OffscreenWindow, monkeypatch: pytest.MonkeyPatch
) -> None:
    waits: list[object] = []
    monkeypatch.setattr(window, "_finish", None)
    monkeypatch.setattr(window.ctx, "finish", lambda: waits.append(window))
    monkeypatch.setattr(window.ctx, "mglo", object())
    window.finish()
    assert waits == [window]


def test_begin_clears(window: OffscreenWindow) -> None:
    window.framebuffer.clear(1.0, 1.0, 1.0)
    window.begin()
    assert not window.read().any()


def test_it_has_the_interface_of_a_window_without_input(window: OffscreenWindow) -> None:
    assert (window.size, window.pixel_ratio, window.should_close, window.poll()) == (SIZE, 1.0, False, [])
    window.toggle_full_screen()
    assert window.size == SIZE


@pytest.mark.parametrize("size", [(0, 10), (10, -1)])
def test_a_size_that_is_not_positive_is_refused(size: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="width and height must be positive"):
        OffscreenWindow(*size)


def test_without_opengl_the_packages_to_install_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(**_: object) -> None:
        raise Exception("cannot open libEGL")

    monkeypatch.setattr(moderngl, "create_context", fail)
    with pytest.raises(GraphicsError, match="sudo apt install libegl1 libgl1 libgl1-mesa-dri"):
        OffscreenWindow(8, 8)


def test_two_windows_do_not_draw_into_each_other(window: OffscreenWindow) -> None:
    window.begin()
    window.framebuffer.clear(0.0, 0.0, 1.0)
    with OffscreenWindow(20, 10) as other:
        other.begin()
        other.framebuffer.clear(1.0, 0.0, 0.0)
        assert other.read()[0, 0].tolist() == [0, 0, 255]
    window.begin()
    window.framebuffer.clear(0.0, 1.0, 0.0)
    assert window.read()[0, 0].tolist() == [0, 255, 0]
