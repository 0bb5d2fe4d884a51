from collections.abc import Callable

import pytest

from conf.animator.gui.panels.expressions import draw_expressions
from tests.animator.conftest import NOW, PanelDriver

pytestmark = pytest.mark.slow


def test_buttons_play_and_release_and_sliders_set_action_units(open_panel: Callable[..., PanelDriver]) -> None:
    panel = open_panel(draw_expressions)
    panel.press("fear")
    assert panel.state.expression.active(NOW) == "fear"
    panel.press("Release")
    assert panel.state.expression.active(NOW) is None
    panel.press("##26 jaw drop")
    assert panel.state.expression.units == {26: pytest.approx(0.5, abs=0.03)}
    panel.press("idle motion: blinks, glances, sway")
    assert not panel.state.expression.idle
    panel.press("Set all to zero")
    assert panel.state.expression.units == {}
