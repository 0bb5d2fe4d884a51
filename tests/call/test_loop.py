"""Two loops over a network in memory: capture and display are simulated, endpoints and exchange are real."""

from collections.abc import Callable
from itertools import count
from typing import Any

import pytest

from conf.call.controls import LocalState
from conf.call.loop import CAMERA_RETRY_S, CallLoop, LocalEnd
from conf.call.self_view import SelfView
from conf.call.shared_objects import SharedObjectSender
from conf.errors import NetworkError
from conf.protocol.address import Address
from conf.protocol.call_endpoint import CallEndpoint
from conf.protocol.participant.state import CameraState
from conf.sender.face_capture import CapturedMotion, CaptureMode
from conf.sender.voice.voice_poller import VOICE_POLL_S
from conf.transport.interface import ReceivedDatagram
from tests.support.simulated_call import A, B
from tests.support.simulated_calls import PARAMETERS, talk
from tests.support.simulated_sessions import CODE, WRONG, seeded

FPS = 15.0


class Wire:
    """Carries datagrams at once. cut : whether nothing arrives"""

    def __init__(self) -> None:
        self.waiting: dict[Address, list[ReceivedDatagram]] = {A: [], B: []}
        self.cut = False


class WireSocket:
    """A socket of one end."""

    candidates = ()
    nameplate = ""
    others_wait = True

    def path_name(self, address: Address) -> str:
        return "direct"

    def __init__(self, wire: Wire, own: Address, remote: Address | None) -> None:
        self.remote = remote
        self.waits: list[float] = []
        self._wire, self._own = wire, own

    def receive(self, limit: int) -> list[ReceivedDatagram]:
        waiting, self._wire.waiting[self._own] = self._wire.waiting[self._own], []
        return waiting

    def send(self, datagrams: list[tuple[bytes, Address]]) -> None:
        for data, address in datagrams if not self._wire.cut else []:
            self._wire.waiting[address].append(ReceivedDatagram(data, self._own, 0.0))

    def wait(self, seconds: float) -> None:
        self.waits.append(seconds)


class FakeCapture:
    """A capture thread without a thread: a face that talks while the mode is ON."""

    def __init__(self) -> None:
        self.mode: CaptureMode | None = None
        self.modes: list[CaptureMode] = []
        self.fps = 0.0
        self.portrait = False
        self.note = self.fault = ""
        self.ended = False
        self.is_working = True
        self.now = self.due = 0.0

    def set_mode(self, mode: CaptureMode) -> None:
        self.mode = mode
        if mode not in self.modes[-1:]:
            self.modes.append(mode)

    def set_fps(self, fps: float) -> None:
        self.fps = fps

    def set_portrait(self, *, is_allowed: bool) -> None:
        self.portrait = is_allowed

    def source_time(self, now: float) -> float:
        return now

    def pop_fault(self) -> str:
        fault, self.fault = self.fault, ""
        return fault

    def drain(self) -> list[CapturedMotion]:
        if self.mode is not CaptureMode.ON or self.now < self.due:
            return []
        self.due = self.now + 1 / FPS
        return [CapturedMotion(self.now, talk(self.now), PARAMETERS.fapu)]


class FakeDisplay:
    """A display that draws nothing. texts : what was reported"""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self.notes: list[str] = []
        self.is_over = False
        self.endpoint: Any = None
        self.shows_somebody = False
        self.is_shown = False

    def show(self) -> None:
        self.is_shown = True

    def step(self, now: float, *, is_flood: bool = False) -> float:
        streams = self.endpoint.streams.values()
        self.shows_somebody = any(stream.motion.frame_at(now) is not None for stream in streams)
        return now + 0.005

    def report(self, text: str, now: float) -> None:
        self.texts.append(text)

    def show_faults(self, note: str, now: float, *, in_call: bool, local: str = "") -> None:
        self.notes.append(note or local)


class FakeVoice:
    """A voice that sends nothing."""

    muted = False
    due_in_s = 0.0

    def poll(self, until: float, outlet: object, now: float) -> None: ...

    def close(self) -> None: ...


class End:
    """One end of a call and all that surrounds its loop."""

    def __init__(
        self,
        wire: Wire,
        own: Address,
        remote: Address | None = None,
        *,
        code: str = CODE,
        name: str = "",
        now: float = 0.0,
    ) -> None:
        self.objects = SharedObjectSender()
        self.endpoint = CallEndpoint(
            code=code,
            parameters=PARAMETERS,
            now=now,
            random=seeded((own, name)),
            remote=remote,
            portrait=self.objects,
            name=name,
        )
        self.socket = WireSocket(wire, own, remote)
        self.capture, self.display, self.voice = FakeCapture(), FakeDisplay(), FakeVoice()
        self.display.endpoint = self.endpoint
        self.state = LocalState()
        self.self_view = SelfView()
        self.local = LocalEnd(self.capture, self.state, self.objects, self.self_view, self.voice)  # type: ignore[arg-type]
        self.loop = CallLoop(
            self.endpoint,
            self.socket,  # type: ignore[arg-type]
            self.local,
            display=self.display,  # type: ignore[arg-type]
        )

    def step(self, now: float) -> float:
        self.capture.now = now
        return self.loop.step(now)

    def hang_up(self, now: float) -> None:
        """Close, and let the time pass that this takes without an answer."""
        ticks = count()
        self.loop.close(now, clock=lambda: now + 0.1 * next(ticks))

    @property
    def received(self) -> int:
        return self.endpoint.report(1e3).frames_received


class Stage:
    """Two ends; b calls a."""

    def __init__(self, *, code: str = CODE) -> None:
        self.now = 0.0
        self.wire = Wire()
        self.a, self.b = End(self.wire, A), End(self.wire, B, A, code=code)

    def run(self, seconds: float) -> None:
        end = self.now + seconds
        while self.now < end:
            for side in (self.a, self.b):
                if not side.loop.is_over:
                    side.step(self.now)
            self.now += 0.01


@pytest.fixture
def stage() -> Stage:
    return Stage()


def test_both_ends_connect_capture_and_draw(stage: Stage) -> None:
    assert not stage.a.display.is_shown
    stage.run(2.0)
    assert stage.a.display.is_shown and stage.b.display.is_shown
    assert stage.a.display.texts == ["connected with 198.51.100.7"]
    assert stage.b.display.texts == ["connected with 192.0.2.1"]
    assert stage.a.capture.modes == stage.b.capture.modes == [CaptureMode.PREVIEW, CaptureMode.ON]
    for end in (stage.a, stage.b):
        assert end.received > 10 and end.capture.fps == end.endpoint.outbound.profile.fps
        assert end.loop.connected_at is not None and end.loop.drawn_at is not None
        assert end.loop.connected_at < 0.2 and end.loop.connected_at < end.loop.drawn_at < 1.0


def test_with_the_camera_off_nothing_of_the_face_is_sent(stage: Stage) -> None:
    stage.run(2.0)
    stage.b.state.camera = False
    stage.run(0.5)
    assert stage.b.capture.mode is CaptureMode.OFF
    count = stage.a.received
    stage.run(3.0)
    assert stage.a.received == count and stage.b.received > 20
    stage.b.state.camera = True
    stage.run(2.0)
    assert stage.a.received > count and stage.b.capture.mode is CaptureMode.ON


def test_a_camera_that_fails_is_said_and_ends_no_call(stage: Stage) -> None:
    stage.run(1.0)
    stage.a.capture.fault = "camera 0 gives no images any more: plug it in again"
    stage.a.capture.is_working = False
    stage.run(1.0)
    assert stage.a.state.camera_fault and stage.a.capture.mode is CaptureMode.OFF
    assert stage.a.display.texts[-1] == "camera 0 gives no images any more: plug it in again"
    assert not stage.a.loop.is_over and stage.b.endpoint.remote_state.camera is CameraState.OFF


def test_a_camera_that_is_missing_is_tried_again_until_it_is_there() -> None:
    stage, fault = Stage(), "there is no camera 0: plug one in, name another, or give a clip instead."
    capture = stage.a.capture
    capture.fault, capture.is_working = fault, False
    stage.run(2.0)
    assert capture.mode is CaptureMode.OFF and stage.b.endpoint.remote_state.camera is CameraState.OFF
    stage.run(CAMERA_RETRY_S)
    assert capture.mode is CaptureMode.ON and not stage.a.state.shows_face and stage.b.received == 0
    capture.fault = fault  # still missing
    stage.run(1.0)
    assert capture.mode is CaptureMode.OFF and stage.a.display.texts.count(fault) == 1
    stage.run(CAMERA_RETRY_S)
    capture.is_working = True
    stage.run(1.0)
    assert stage.a.state.shows_face and stage.b.received > 5
    assert stage.b.endpoint.remote_state.camera is CameraState.ON


def test_a_camera_that_was_switched_off_is_not_tried() -> None:
    stage = Stage()
    stage.a.capture.fault, stage.a.capture.is_working = "there is no camera 0", False
    stage.a.state.camera = False
    stage.run(CAMERA_RETRY_S + 1.0)
    assert stage.a.capture.mode is CaptureMode.OFF


def test_the_switches_reach_the_microphone_and_the_portrait(stage: Stage) -> None:
    stage.run(0.1)
    assert not stage.a.voice.muted and not stage.a.objects.is_allowed and not stage.a.capture.portrait
    stage.a.state.microphone, stage.a.state.portrait = False, True
    stage.run(0.1)
    assert stage.a.voice.muted and stage.a.objects.is_allowed and stage.a.capture.portrait


def test_a_portrait_that_is_switched_off_is_withdrawn_at_the_other_end(stage: Stage) -> None:
    def withdrawn() -> list[bool]:
        return [stream.is_portrait_withdrawn for stream in stage.b.endpoint.streams.values()]

    stage.run(1.0)
    stage.a.state.portrait = True
    stage.run(0.5)
    assert withdrawn() == [False]
    stage.a.state.portrait = False
    stage.run(0.3)
    assert withdrawn() == [True]
    stage.a.state.portrait = True
    stage.run(0.3)
    assert withdrawn() == [False]


def test_who_has_called_ends_when_the_other_hangs_up_and_who_waits_goes_on() -> None:
    stage = Stage()
    stage.run(1.0)
    stage.a.hang_up(stage.now)
    stage.run(0.5)
    assert stage.b.loop.is_over and stage.b.display.texts[-1] == "the other end has hung up"
    stage = Stage()
    stage.run(1.0)
    stage.b.hang_up(stage.now)
    stage.b.display.is_over = True
    stage.run(0.5)
    assert stage.a.display.texts[-1] == "the other end has hung up"
    assert not stage.a.loop.is_over and stage.a.capture.mode is CaptureMode.PREVIEW


def test_who_hangs_up_waits_until_the_other_end_has_answered() -> None:
    stage, ticks = Stage(), count()
    stage.run(1.0)

    def clock() -> float:
        stage.b.step(stage.now)  # the other end goes on meanwhile
        return stage.now + 0.01 * next(ticks)

    before = len(stage.a.socket.waits)
    stage.a.loop.close(stage.now, clock=clock)
    assert stage.b.loop.is_over and len(stage.a.socket.waits) - before <= 2
    stage = Stage()
    stage.run(1.0)
    stage.wire.cut = True
    stage.a.hang_up(stage.now)
    assert 5 <= len(stage.a.socket.waits) <= 12


def test_the_next_caller_is_not_called_by_the_name_of_the_one_before() -> None:
    stage = Stage()
    stage.b = End(stage.wire, B, A, name="Bob")
    stage.run(1.0)
    assert stage.a.loop.peer_name == "Bob"
    stage.b.hang_up(stage.now)
    stage.run(0.5)
    assert stage.a.display.texts[-1] == "Bob has hung up" and stage.a.loop.peer_name == "Bob"
    stage.b = End(stage.wire, B, A, now=stage.now)
    stage.run(1.0)
    assert stage.a.display.texts[-1] == "connected with 198.51.100.7" and stage.a.loop.peer_name == ""


def test_a_wrong_code_ends_the_call_with_a_message() -> None:
    stage = Stage(code=WRONG)
    with pytest.raises(NetworkError, match="the code is wrong"):
        stage.run(5.0)
    assert stage.a.display.texts == ["a wrong code from 198.51.100.7: 4 more tries for now"]


def test_the_call_comes_back_after_the_network_was_gone(stage: Stage) -> None:
    stage.run(1.0)
    stage.wire.cut = True
    stage.run(8.0)
    count = stage.a.received
    stage.wire.cut = False
    stage.run(6.0)
    assert stage.a.received > count + 20


def test_a_step_is_due_early_enough_for_the_voice(stage: Stage) -> None:
    assert stage.a.step(0.0) == pytest.approx(VOICE_POLL_S)
    assert stage.b.loop.run(seconds=0.0) is None  # type: ignore[func-returns-value]


@pytest.mark.parametrize("end", [lambda side: setattr(side.capture, "ended", True), lambda side: None])
def test_run_ends_with_the_clip_or_when_it_should_not_continue(end: Callable[[End], None]) -> None:
    side, ticks = Stage().a, iter(range(10_000))
    end(side)
    going = iter([True] * 5)
    side.loop.run(should_continue=lambda: next(going, False), clock=lambda: next(ticks) / 100)
    assert len(side.socket.waits) == (0 if side.capture.ended else 5)


def test_without_a_display_a_call_is_held_all_the_same() -> None:
    stage = Stage()
    stage.b.loop = CallLoop(
        stage.b.endpoint,
        stage.b.socket,  # type: ignore[arg-type]
        stage.b.local,
    )
    stage.run(2.0)
    assert stage.a.received > 10 and stage.a.endpoint.remote_state.camera is CameraState.ON
