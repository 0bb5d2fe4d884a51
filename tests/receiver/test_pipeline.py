from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.deformation.face_model import FaceModel
from conf.protocol.address import Address
from conf.protocol.statistics import TrafficSnapshot
from conf.receiver.participant_grid import Window
from conf.receiver.pipeline import ReceivingLoop
from conf.receiver.stats_overlay import CallStats
from conf.render.window.offscreen import OffscreenWindow
from conf.transport.udp import ReceivedDatagram
from tests.support.fake_senders import FakeCaller, new_host

FPS = 8.0
Datagrams = list[tuple[bytes, Address]]


class FakeLink:
    """A socket with callers at its other end, and the clock that goes on while the loop waits."""

    def __init__(self, *callers: FakeCaller) -> None:
        self.now = 0.0
        self.callers = callers
        self.arrived: Datagrams = []

    def monotonic(self) -> float:
        return self.now

    def receive(self, limit: int = 4096) -> list[ReceivedDatagram]:
        arrived, self.arrived = self.arrived[:limit], self.arrived[limit:]
        return [ReceivedDatagram(data, address, 0.0) for data, address in arrived]

    def send(self, datagrams: Datagrams) -> None:
        for caller in self.callers:
            caller.hear(datagrams, self.now)

    def wait(self, seconds: float) -> None:
        self.now += max(min(seconds, 0.02), 1e-4)
        for caller in self.callers:
            self.arrived += caller.speak(self.now)


@dataclass
class Shown:
    """What a run of the loop showed."""

    traffic: TrafficSnapshot | None = None
    events: list[str] = field(default_factory=list)
    states: list[str] = field(default_factory=list)
    notices: list[str] = field(default_factory=list)
    labels: set[str] = field(default_factory=set)
    pictures: list[NDArray[np.uint8]] = field(default_factory=list)


class Theatre:
    """Runs the loop over a fake link and writes down what it shows."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, face: FaceModel) -> None:
        self._patch, self._window, self._face = monkeypatch, window, face

    def run(self, link: FakeLink, seconds: float, acts: dict[float, tuple[FakeCaller, str | None]]) -> Shown:
        """acts : at which time which caller begins to show what; "hang up" ends a call"""
        shown, rest = Shown(), dict(acts)

        def note_meter(_: object, reading: CallStats) -> None:
            shown.states.append(reading.state)

        def note_picture(window: Window, now: float) -> None:
            shown.pictures.append(window.read())
            for time in [time for time in rest if time <= now]:
                caller, what = rest.pop(time)
                if what == "hang up":
                    link.arrived += caller.hang_up(now)
                caller.shows = None if what == "hang up" else what

        self._patch.setattr("conf.receiver.pipeline.time", link)
        self._patch.setattr("conf.receiver.pipeline.draw_stats", note_meter)
        self._patch.setattr("conf.receiver.pipeline.draw_toast", lambda _, text: shown.notices.append(text))
        self._patch.setattr("conf.receiver.pipeline.draw_label", lambda _, text, at: shown.labels.add(text))
        loop = ReceivingLoop(self._window, self._face, new_host(), link, idle_text="listening")  # type: ignore[arg-type]
        shown.traffic = loop.run(fps=FPS, seconds=seconds, on_picture=note_picture, on_event=shown.events.append)
        return shown


@pytest.fixture
def theatre(monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, face: FaceModel) -> Theatre:
    return Theatre(monkeypatch, window, face)


def in_turn(words: list[str]) -> list[str]:
    return [word for i, word in enumerate(words) if i == 0 or words[i - 1] != word]


def test_a_call_from_its_greeting_to_its_end(theatre: Theatre) -> None:
    caller = FakeCaller(0.0)
    caller.shows = None
    acts = {1.0: (caller, "face"), 3.0: (caller, "nobody"), 5.0: (caller, None), 9.5: (caller, "hang up")}
    shown = theatre.run(FakeLink(caller), 13.5, acts)
    assert shown.events == ["a call from 10.0.0.7", "a call has ended"]
    assert in_turn(shown.states) == ["waiting", "receiving", "no face", "lost", "call ended"]
    assert in_turn(shown.notices) == ["listening", "a call from 10.0.0.7", "a call has ended", "listening"]
    assert shown.traffic and shown.traffic.frames_received > 20 and shown.traffic.frames_lost == 0
    still, moving = shown.pictures[: int(FPS)], shown.pictures[int(2 * FPS) : int(3 * FPS)]
    assert all((picture == still[0]).all() for picture in still)
    assert all((a != b).any() for a, b in pairwise(moving))


def test_pictures_come_at_their_rate(theatre: Theatre) -> None:
    shown = theatre.run(FakeLink(FakeCaller(0.0)), 2.0, {})
    assert len(shown.pictures) == pytest.approx(2.0 * FPS, abs=1)


def test_a_wrong_code_is_told_and_shows_nothing(theatre: Theatre) -> None:
    shown = theatre.run(FakeLink(FakeCaller(0.0, code="acorn-tulip-river-42")), 1.5, {})
    assert shown.events == ["a wrong code from 10.0.0.7: 4 more tries this minute"]
    assert set(shown.states) == {"waiting"}
    assert all((picture == shown.pictures[0]).all() for picture in shown.pictures)


def test_several_callers_are_told_apart_by_their_addresses(theatre: Theatre) -> None:
    callers = FakeCaller(0.0), FakeCaller(0.0, address=("10.0.0.9", 4321))
    shown = theatre.run(FakeLink(*callers), 1.5, {})
    assert sorted(shown.events) == ["a call from 10.0.0.7", "a call from 10.0.0.9"]
    assert shown.labels == {"10.0.0.7:1234", "10.0.0.9:4321"}


def test_keep_going_ends_it(monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, face: FaceModel) -> None:
    link = FakeLink()
    monkeypatch.setattr("conf.receiver.pipeline.time", link)
    loop = ReceivingLoop(window, face, new_host(), link)  # type: ignore[arg-type]
    assert loop.run(fps=FPS, keep_going=lambda: link.now < 0.5).datagrams == 0
