from collections.abc import Callable

import pytest

from conf.animator.gui.panels.view import draw_view
from tests.animator.conftest import PanelDriver

pytestmark = pytest.mark.slow


def test_style_points_and_direction(open_panel: Callable[..., PanelDriver]) -> None:
    panel = open_panel(draw_view)
    panel.press("regions")
    panel.press("control points")
    panel.press("left")
    view = panel.state.view
    assert view.style == "regions" and view.camera.points and view.camera.yaw > 1.5
    panel.press("Reset rotation, position and zoom")
    assert panel.state.view.camera.yaw == 0
