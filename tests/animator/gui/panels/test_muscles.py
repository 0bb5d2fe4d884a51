from collections.abc import Callable

import pytest

from conf.animator.gui.panels.muscles import draw_muscles
from tests.animator.conftest import PanelDriver


def test_a_slider_contracts_both_sides(open_panel: Callable[..., PanelDriver]) -> None:
    panel = open_panel(draw_muscles)
    panel.press("##corrugator")
    assert panel.state.muscles.active
    contractions = panel.state.muscles.contractions
    assert contractions["corrugator_l"] == pytest.approx(0.25, abs=0.03)
    assert contractions["corrugator_r"] == contractions["corrugator_l"]
    panel.press("relaxed")
    assert not panel.state.muscles.contractions
