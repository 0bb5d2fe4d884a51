from collections.abc import Callable
from dataclasses import replace

import numpy as np

from conf.animator.panels.face import draw_face
from conf.animator.placing import Placing
from conf.animator.requests import AcceptPoints, PlacePoints
from tests.animator.conftest import Worked


def test_placing_is_asked_for_and_ok_only_when_all_are_placed(work: Callable[..., Worked]) -> None:
    panel = work(draw_face)
    panel.press("Place points ...")
    assert panel.requests == [PlacePoints()]
    panel.requests.clear()
    panel.desk = replace(panel.desk, placing=Placing())
    panel.press("OK")
    assert panel.requests == []
    panel.desk = replace(panel.desk, placing=Placing(np.ones((50, 3))))
    panel.press("OK")
    assert panel.requests == [AcceptPoints()]
