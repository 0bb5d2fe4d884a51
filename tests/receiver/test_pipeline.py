from dataclasses import dataclass, field
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.errors import NetworkError
from conf.face.deformation.face_model import FaceModel
from conf.protocol.address import Address, RelayAddress
from conf.protocol.call_report import CallReport
from conf.protocol.session.events import AddressChanged, Event, NoAnswer, WrongCode
from conf.protocol.voice.inbound import InboundVoice
from conf.receiver.call_display import LoopOptions
from conf.receiver.call_stats import CallStats
from conf.receiver.pipeline import ReceiverLoop, describe_event
from conf.receiver.voice.call_sound import ClipSound
from conf.receiver.voice.participant_voice import ParticipantVoice
from conf.receiver.voice.voice_mixer import VoiceMixer
from conf.render.window import Window
from conf.render.window.offscreen import OffscreenWindow
from conf.transport.exchange import RECEIVE_BATCH
from conf.transport.interface import ReceivedDatagram
from tests.support.simulated_calls import SimulatedSender, make_receiver, no_face, talk
from tests.support.simulated_sessions import WRONG

FPS = 8.0
Datagrams = list[tuple[bytes, Address]]
ADDRESS = ("10.0.0.7", 1234)
MOTIONS = {"face": talk, "nobody": no_face}


class FakeSocket:
    """A socket with callers at its other end; its clock advances while the loop waits."""

    candidates = ()
    nameplate = ""

    def __init__(self, *callers: SimulatedSender) -> None:
        self.now = 0.0
        self.callers = callers
        self.arrived: Datagrams = []

    def clock(self) -> float:
        return self.now

    def path_name(self, address: Address) -> str:
        return "relay over TCP" if isinstance(address, RelayAddress) else "direct"

    def receive(self, limit: int) -> list[ReceivedDatagram]:
        arrived, self.arrived = self.arrived[:limit], self.arrived[limit:]
        return [ReceivedDatagram(data, address, 0.0) for data, address in arrived]

    def send(self, datagrams: Datagrams) -> None:
        for caller in self.callers:
            caller.receive(datagrams, self.now)

    def wait(self, seconds: float) -> None:
        self.now += max(min(seconds, 0.02), 1e-4)
        for caller in self.callers:
            self.arrived += [(data, caller.address) for data, _ in caller.datagrams_to_send(self.now)]


@dataclass
class Shown:
    """What a run of the loop showed."""

    traffic: CallReport | None = None
    events: list[str] = field(default_factory=list)
    states: list[str] = field(default_factory=list)
    toasts: list[str] = field(default_factory=list)
    labels: set[str] = field(default_factory=set)
    images: list[NDArray[np.uint8]] = field(default_factory=list)


class LoopRunner:
    """Runs the loop over a fake socket and records what it shows."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, face: FaceModel) -> None:
        self._patch, self._window, self._face = monkeypatch, window, face

    def run(self, socket: FakeSocket, seconds: float, script: dict[float, tuple[SimulatedSender, str | None]]) -> Shown:
        """script : time -> caller and what its camera sees from then on; "hang up" ends the call"""
        shown, remaining = Shown(), dict(script)

        def record_stats(_: object, stats: CallStats) -> None:
            shown.states.append(stats.state)

        def record_image(window: Window, now: float) -> None:
            shown.images.append(window.read())
            for time in [time for time in remaining if time <= now]:
                caller, what = remaining.pop(time)
                if what == "hang up":
                    socket.arrived += [(data, caller.address) for data, _ in caller.connection.close(now)]
                caller.is_on = what in MOTIONS
                caller.motion = MOTIONS.get(what or "")

        panels = "conf.receiver.call_panels"
        self._patch.setattr(f"{panels}.draw_stats_line", record_stats)
        self._patch.setattr(
            "conf.receiver.notifications.draw_toast", lambda text, anchor, **_: shown.toasts.append(text)
        )
        self._patch.setattr(f"{panels}.draw_label", lambda text, corner, highlighted: shown.labels.add(text))
        options = LoopOptions(FPS, "listening", record_image, shown.events.append)
        loop = ReceiverLoop(self._window, self._face, make_receiver(), socket, options)  # type: ignore[arg-type]
        shown.traffic = loop.run(seconds=seconds, clock=socket.clock)
        return shown


@pytest.fixture
def runner(monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, face: FaceModel) -> LoopRunner:
    return LoopRunner(monkeypatch, window, face)


def without_repetitions(words: list[str]) -> list[str]:
    return [word for i, word in enumerate(words) if i == 0 or words[i - 1] != word]


@pytest.mark.slow
def test_a_call_from_its_start_to_its_end(runner: LoopRunner) -> None:
    caller = SimulatedSender(0.0, address=ADDRESS)
    caller.is_on = False
    script = {1.0: (caller, "face"), 3.0: (caller, "nobody"), 5.0: (caller, None), 9.5: (caller, "hang up")}
    shown = runner.run(FakeSocket(caller), 13.5, script)
    assert shown.events == ["a call from 10.0.0.7", "a call has ended"]
    assert without_repetitions(shown.states) == ["waiting", "receiving", "no face", "lost", "call ended"]
    assert without_repetitions(shown.toasts) == ["listening", "a call from 10.0.0.7", "a call has ended", "listening"]
    assert shown.traffic and shown.traffic.frames_received > 20 and shown.traffic.frames_lost == 0
    still, moving = shown.images[: int(FPS)], shown.images[int(2 * FPS) : int(3 * FPS)]
    assert all((image == still[0]).all() for image in still)
    assert all((a != b).any() for a, b in pairwise(moving))


@pytest.mark.slow
def test_frames_are_drawn_at_their_rate(runner: LoopRunner) -> None:
    shown = runner.run(FakeSocket(SimulatedSender(0.0)), 2.0, {})
    assert len(shown.images) == pytest.approx(2.0 * FPS, abs=1)


@pytest.mark.slow
def test_a_wrong_code_is_reported_and_shows_no_caller(runner: LoopRunner) -> None:
    shown = runner.run(FakeSocket(SimulatedSender(0.0, code=WRONG, address=ADDRESS)), 1.5, {})
    assert shown.events == ["a wrong code from 10.0.0.7: 4 more tries for now"]
    assert set(shown.states) == {"waiting"}
    assert all((image == shown.images[0]).all() for image in shown.images)


@pytest.mark.slow
def test_several_callers_are_labelled_with_their_addresses(runner: LoopRunner) -> None:
    callers = SimulatedSender(0.0, address=ADDRESS), SimulatedSender(0.0, address=("10.0.0.9", 4321))
    shown = runner.run(FakeSocket(*callers), 1.5, {})
    assert sorted(shown.events) == ["a call from 10.0.0.7", "a call from 10.0.0.9"]
    assert shown.labels == {"10.0.0.7:1234", "10.0.0.9:4321"}


class RelaySocket(FakeSocket):
    """A socket whose first caller leaves the relay at `direct_at`; it moves once more half a second later."""

    nameplate = "4711"
    direct_at = 2.0

    def wait(self, seconds: float) -> None:
        if self.now >= self.direct_at:
            self.callers[0].address = ("10.0.0.7", 40000 if self.now < self.direct_at + 0.5 else 40001)
        super().wait(seconds)


@pytest.mark.slow
def test_over_a_relay_the_label_is_the_path_and_moves_are_told_once(runner: LoopRunner) -> None:
    callers = [SimulatedSender(0.0, address=RelayAddress("4711", member * 4)) for member in "ab"]
    for caller in callers:
        caller.motion = talk
    shown = runner.run(RelaySocket(*callers), 4.0, {})
    assert shown.labels == {"relay over TCP", "10.0.0.7:40000", "10.0.0.7:40001"}
    assert shown.events == ["somebody calls"] * 2 + ["a call goes directly now"]
    assert shown.traffic
    assert sorted((row.caller, row.path) for row in shown.traffic.callers) == [
        ("10.0.0.7:40001", "direct"),
        ("relay/bbbb", "relay over TCP"),
    ]


@pytest.mark.parametrize(
    ("event", "over_relay", "text"),
    [
        (AddressChanged(1, ADDRESS), False, "a caller has moved to 10.0.0.7"),
        (AddressChanged(1, RelayAddress("4711", "aaaa")), True, "the direct path of a call has failed: it goes over"),
        (WrongCode(4, ADDRESS), False, "a wrong code from 10.0.0.7: 4 more tries for now"),
        (WrongCode(4, RelayAddress("4711", "aaaa")), True, "a wrong code: 4 more tries for now"),
        (NoAnswer(5.0), True, ""),
    ],
)
def test_what_a_viewer_is_told_of_an_event(event: Event, over_relay: bool, text: str) -> None:
    told = describe_event(event, over_relay=over_relay)
    assert told.startswith(text) and bool(told) == bool(text)


class FailingSocket(FakeSocket):
    """A socket of a machine that cannot send, or receive, for some time."""

    def __init__(self, caller: SimulatedSender, verb: str, times: tuple[float, float]) -> None:
        super().__init__(caller)
        self.verb, self.times = verb, times

    def fail(self, verb: str) -> None:
        if verb == self.verb and self.times[0] < self.now < self.times[1]:
            raise NetworkError(f"nothing can be {verb}")

    def receive(self, limit: int) -> list[ReceivedDatagram]:
        self.fail("received")
        return super().receive(limit)

    def send(self, datagrams: Datagrams) -> None:
        if datagrams:
            self.fail("sent")
        super().send(datagrams)


@pytest.mark.slow
@pytest.mark.parametrize("verb", ["sent", "received"])
def test_a_network_failure_that_passes_is_shown_and_survived(runner: LoopRunner, verb: str) -> None:
    caller = SimulatedSender(0.0, address=ADDRESS)
    shown = runner.run(FailingSocket(caller, verb, (2.0, 5.0)), 8.0, {})
    assert shown.events[0] == "a call from 10.0.0.7"
    assert shown.events[1] == f"nothing can be {verb} (trying for 10 s more)"
    assert shown.events[2:] == ["it works again"]
    assert any(toast.startswith(f"nothing can be {verb} (trying for") for toast in shown.toasts)
    assert shown.states[-1] == "receiving"


@pytest.mark.slow
@pytest.mark.parametrize("verb", ["sent", "received"])
def test_a_network_failure_that_lasts_ends_the_program(runner: LoopRunner, verb: str) -> None:
    socket = FailingSocket(SimulatedSender(0.0, address=ADDRESS), verb, (2.0, 99.0))
    with pytest.raises(NetworkError, match=f"nothing can be {verb}"):
        runner.run(socket, 30.0, {})
    assert 11.9 < socket.now < 13.0


@pytest.mark.slow
def test_an_answer_to_a_stranger_that_cannot_be_sent_ends_nothing(runner: LoopRunner) -> None:
    """The source of a first datagram may be forged: there is no such address."""
    socket = FailingSocket(SimulatedSender(0.0, address=ADDRESS), "sent", (0.0, 99.0))
    shown = runner.run(socket, 14.0, {})
    assert shown.events == [] and set(shown.states) == {"waiting"}
    assert "nothing can be sent" in shown.toasts


@pytest.mark.slow
def test_the_loop_ends_when_it_should_not_continue(window: OffscreenWindow, face: FaceModel) -> None:
    socket = FakeSocket()
    loop = ReceiverLoop(window, face, make_receiver(), socket, LoopOptions(FPS))  # type: ignore[arg-type]
    assert loop.run(should_continue=lambda: socket.now < 0.5, clock=socket.clock).datagrams == 0


@pytest.mark.slow
def test_a_flood_delays_a_frame_by_at_most_the_time_that_drawing_took(window: OffscreenWindow, face: FaceModel) -> None:
    """Frames are due every 0.1 s, drawing takes 0.3 s, and each step receives a full batch of junk."""
    flood = [ReceivedDatagram(b"junk", ("10.0.0.1", 1), 0.0)] * RECEIVE_BATCH
    socket = SimpleNamespace(receive=lambda limit: flood, send=lambda datagrams: None, candidates=())
    frames: list[float] = []
    options = LoopOptions(10.0, on_frame=lambda _, now: frames.append(now))
    loop = ReceiverLoop(window, face, make_receiver(), socket, options)
    assert loop.step(5.0) == 5.0
    for now in (5.3, 5.4, 5.5, 5.59, 5.61):
        loop.step(now)
    loop.close()
    assert frames == [5.0, 5.61]


@pytest.mark.slow
def test_a_voice_in_an_unknown_codec_is_reported_once(window: OffscreenWindow, face: FaceModel) -> None:
    rng, events, endpoint = np.random.default_rng(1), list[str](), make_receiver()
    mixer = VoiceMixer(endpoint.streams, rng)
    mixer.participants[7] = ParticipantVoice(InboundVoice(), rng)
    mixer.participants[7].unknown_codec = "voice in a codec unknown here"
    options = LoopOptions(FPS, on_event=events.append, sound=ClipSound(mixer))
    loop = ReceiverLoop(window, face, endpoint, FakeSocket(), options)  # type: ignore[arg-type]
    for now in (0.0, 0.2, 0.4):
        loop.step(now)
    loop.close()
    assert events == ["voice in a codec unknown here"]
