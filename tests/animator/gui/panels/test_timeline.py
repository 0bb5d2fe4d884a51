from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from conf.animator.commands import Seek, SetLoop, StepFrames, Stop, ToggleMotionRecording, TogglePlaying
from conf.animator.gui.panels.timeline import draw_timeline
from conf.animator.motion_player import MotionPlayer, NamedClip
from conf.face.formats.dpc import MotionClip
from tests.animator.conftest import Worked


def test_the_player_is_asked_for_what_its_buttons_say(work: Callable[..., Worked]) -> None:
    panel = work(lambda desk, facts: draw_timeline(desk, facts, 1.0))
    panel.press("Record a take")
    assert panel.requests == [ToggleMotionRecording()]
    panel.requests.clear()
    motion = MotionClip(10.0, "fapu", np.zeros((21, 50, 3), np.float32))
    panel.facts = replace(panel.facts, player=MotionPlayer(NamedClip("a", motion)))
    for label in ("Play", "Stop", "<", ">", "loop"):
        panel.press(label)
    assert panel.requests == [TogglePlaying(), Stop(), StepFrames(-1), StepFrames(1), SetLoop(False)]
    panel.press("##seek")
    seek = panel.requests[-1]
    assert isinstance(seek, Seek) and seek.position == pytest.approx(1.0, abs=0.05)
