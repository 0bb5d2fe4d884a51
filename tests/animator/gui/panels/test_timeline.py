from collections.abc import Callable

import numpy as np
import pytest

from conf.animator.gui.panels.timeline import draw_timeline
from conf.face.formats.dpc import MotionClip
from tests.animator.conftest import NOW, PanelDriver

pytestmark = pytest.mark.slow


def test_buttons_and_seek_bar_work_the_player(open_panel: Callable[..., PanelDriver]) -> None:
    panel = open_panel(lambda controller, now: draw_timeline(controller, now, 0.3))  # all buttons fit into the window
    panel.press("Record motion")
    assert panel.controller.recorder is not None
    panel.press("Stop recording")
    assert panel.controller.recorder is None
    panel.controller.play_clip("a", MotionClip(10.0, "fapu", np.zeros((21, 50, 3), np.float32)), NOW)
    player = panel.controller.player
    assert player is not None
    panel.press("Pause")
    assert not player.is_playing(NOW)
    panel.press("##seek")
    assert player.position(NOW) == pytest.approx(1.0, abs=0.05)
    frame = player.frame(NOW)
    panel.press("<")
    assert player.frame(NOW) in (frame, frame - 1), "the start of the frame or the one before"
    frame = player.frame(NOW)
    panel.press(">")
    assert player.frame(NOW) == frame + 1
    panel.press("loop")
    assert not player.loop
    panel.press("Play")
    assert player.is_playing(NOW)
    panel.press("Stop")
    assert not player.is_playing(NOW) and player.position(NOW) == 0
    panel.press("Close")
    assert panel.controller.player is None
