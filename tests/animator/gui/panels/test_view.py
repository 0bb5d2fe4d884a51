from collections.abc import Callable

from conf.animator.gui.panels.view import draw_view
from tests.animator.conftest import Worked


def test_style_points_and_direction(work: Callable[..., Worked]) -> None:
    panel = work(draw_view)
    panel.press("regions")
    panel.press("control points")
    panel.press("left")
    look = panel.desk.look
    assert look.style == "regions" and look.view.points and look.view.yaw > 1.5
    panel.press("Reset turn, place and zoom")
    assert panel.desk.look.view.yaw == 0
