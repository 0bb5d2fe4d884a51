import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from conf.face.fapu import Fapu
from conf.protocol.messages import MotionFrame
from conf.protocol.portrait.object_sender import ObjectSender
from conf.sender.portrait.captured_face import CapturedFace
from conf.sender.portrait.deferred_scheduler import DeferredPortraitScheduler
from conf.sender.tracking.canonical_face import load_canonical_face


def test_frames_reach_one_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[Any] = []

    class Scheduler:
        def __init__(self, *arguments: object) -> None:
            made.append(arguments)

        def process_frame(self, *arguments: object) -> None:
            made.append(arguments)

    monkeypatch.setattr("conf.sender.portrait.scheduler.PortraitScheduler", Scheduler)
    canonical, objects = load_canonical_face(), ObjectSender()
    deferred = DeferredPortraitScheduler(canonical, objects)
    assert made == []
    fapu = Fapu(6.4, 4.5, 3.0, 5.0, 1.1)
    face = CapturedFace(np.zeros((4, 4, 3), np.uint8), np.zeros((478, 3)), np.zeros((50, 3)), fapu)
    motion = MotionFrame(0.0, np.zeros((50, 3), np.float32), np.zeros(6))
    for now in (1.0, 2.0):
        deferred.process_frame(face, motion, 0.9, now)
    assert made == [(canonical, objects), (face, motion, 0.9, 1.0), (face, motion, 0.9, 2.0)]


@pytest.mark.slow
def test_a_source_without_a_portrait_needs_neither_scipy_nor_pillow() -> None:
    check = "import sys, conf.sender.motion_source, conf.sender.portrait.deferred_scheduler as d; "
    check += "sys.exit(bool({'scipy', 'PIL'} & sys.modules.keys()))"
    assert subprocess.run([sys.executable, "-P", "-c", check], check=False).returncode == 0
