from collections.abc import Callable

import pytest

from conf.animator.commands import PlayExpression, ReleaseExpressions
from conf.animator.gui.panels.expressions import draw_emotions
from tests.animator.conftest import Worked


def test_buttons_play_and_sliders_hold_action_units(work: Callable[..., Worked]) -> None:
    panel = work(draw_emotions)
    panel.press("fear")
    panel.press("Release")
    assert panel.requests == [PlayExpression("fear"), ReleaseExpressions()]
    panel.press("##26 jaw drop")
    assert panel.desk.expressing.units == {26: pytest.approx(0.5, abs=0.03)}
    panel.press("idle life: blinks, glances, sways")
    assert not panel.desk.expressing.idle
    panel.press("All to zero")
    assert panel.desk.expressing.units == {}
