"""The level of the chosen microphone."""

import threading
from typing import Any

import numpy as np

from conf.audio.devices import NULL_DEVICE, Microphone, open_microphone
from conf.audio.samples import AudioBlock
from conf.errors import AudioError
from conf.start.devices.level_meter import FLOOR_DBFS
from conf.start.devices.microphone_meter import MicrophoneMeter

LIMIT_S = 20.0


class FakeMicrophone:
    """A microphone that gives one loud block, then nothing."""

    def __init__(self) -> None:
        self.read_again, self.closed = threading.Event(), threading.Event()
        self._blocks = [AudioBlock(0.0, np.full(320, 16384, np.int16))]

    def read(self) -> AudioBlock | None:
        if self._blocks:
            return self._blocks.pop()
        self.read_again.set()
        return None

    def __enter__(self) -> "FakeMicrophone":
        return self

    def __exit__(self, *_: object) -> None:
        self.closed.set()


def test_the_level_is_that_of_the_newest_sound() -> None:
    microphone: Any = FakeMicrophone()
    meter = MicrophoneMeter("Headset", opener=lambda name: microphone)
    assert microphone.read_again.wait(LIMIT_S)
    assert 0.89 < meter.level < 0.91 and -6.1 < (1 - meter.level) * FLOOR_DBFS < -6.0
    assert meter.error == ""
    meter.begin_close()
    assert meter.close() and microphone.closed.is_set()


def test_without_a_microphone_there_is_a_reason() -> None:
    failed = threading.Event()

    def opener(name: str | None) -> Microphone:
        failed.set()
        raise AudioError("there is no microphone here: plug one in, or go on without sound.")

    meter = MicrophoneMeter(None, opener=opener)
    assert failed.wait(LIMIT_S)
    meter.close()
    assert meter.error.startswith("there is no microphone here") and meter.level == 0


def test_a_silent_microphone_shows_nothing() -> None:
    opened: list[Microphone] = []

    def opener(name: str | None) -> Microphone:
        opened.append(open_microphone(name))
        ready.set()
        return opened[0]

    ready = threading.Event()
    meter = MicrophoneMeter(NULL_DEVICE, opener=opener)
    assert ready.wait(LIMIT_S) and meter.close()
    assert meter.level == 0 and meter.error == ""
