from collections.abc import Callable

import numpy as np
import pytest
from imgui_bundle import imgui

from conf.render.ui.imgui_overlay import MUTED
from conf.render.ui.theme import AMBER
from conf.render.ui.wrapped_text import hint, warning
from tests.support.imgui_stage import Stage

TEXT = "a text that is much longer than the panel is wide and so takes several lines of it"


@pytest.mark.parametrize(("draw", "colour"), [(hint, MUTED), (warning, AMBER)])
def test_texts_are_wrapped_in_their_colour(
    draw: Callable[[str], None], colour: tuple[float, ...], stage: Stage
) -> None:
    sizes: list[tuple[float, float]] = []

    def measure() -> None:
        draw(TEXT)
        size = imgui.get_item_rect_size()
        sizes.append((size.x, size.y))

    stage.frame(measure)
    width, height = sizes[0]
    assert width < stage.rect.width and height > 1.9 * imgui.get_font_size()
    brightest = stage.window.read()[:, :, ::-1].reshape(-1, 3).max(axis=0) / 255
    np.testing.assert_allclose(brightest, colour[:3], atol=0.06)
