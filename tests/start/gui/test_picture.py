"""The camera's picture: drawn as large as fits, or the reason why there is none."""

from typing import Any

import numpy as np
import pytest

from conf.start.gui.picture import CameraPicture
from tests.support.image_measures import box
from tests.support.imgui_stage import Stage

RED = (255, 0, 0, 255)


class FakePreview:
    """A preview of red images, 40 x 20 pixels."""

    def __init__(self, error: str = "", count: int = 1) -> None:
        self.error, self.count = error, count

    def newest(self) -> tuple[int, Any]:
        return self.count, np.full((20, 40, 4), RED, np.uint8) if self.count else None


def red_box(stage: Stage, preview: Any, picture: CameraPicture) -> tuple[int, int, int, int] | None:
    """Return the box of what is red after a frame."""
    picture.prepare(preview)
    stage.frame(lambda: picture.draw(stage.overlay, preview, (200.0, 150.0)))
    pixels = stage.window.read().astype(int)
    red = (pixels[:, :, 2] > 250) & (pixels[:, :, 1] < 5)
    return box(red) if red.any() else None


def test_the_image_fills_the_width_and_keeps_its_shape(stage: Stage) -> None:
    with CameraPicture(stage.window.ctx) as picture:
        left, top, right, bottom = red_box(stage, FakePreview(), picture) or (0, 0, 0, 0)
        assert (right - left, bottom - top) == (200, 100)
        assert top - 8 == pytest.approx(25, abs=1)  # in the middle, below the panel's padding


def test_an_error_or_another_camera_replaces_the_image(stage: Stage) -> None:
    with CameraPicture(stage.window.ctx) as picture:
        assert red_box(stage, FakePreview(), picture)
        assert red_box(stage, FakePreview("there is no camera 0: plug one in"), picture) is None
        assert red_box(stage, FakePreview(count=0), picture) is None
        assert red_box(stage, None, picture) is None
        assert red_box(stage, FakePreview(count=2), picture)
