from collections.abc import Callable

import pytest

from conf.animator.gui.panels.muscles import draw_muscles
from tests.animator.conftest import Worked


def test_a_slider_contracts_both_sides(work: Callable[..., Worked]) -> None:
    panel = work(draw_muscles)
    panel.press("##corrugator")
    assert panel.desk.muscling.active
    assert panel.desk.muscling.contractions["corrugator_l"] == pytest.approx(0.25, abs=0.03)
    assert panel.desk.muscling.contractions["corrugator_r"] == panel.desk.muscling.contractions["corrugator_l"]
    panel.press("relaxed")
    assert not panel.desk.muscling.contractions
