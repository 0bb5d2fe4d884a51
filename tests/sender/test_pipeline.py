import random
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from conf.errors import AudioError, CameraError, NetworkError
from conf.protocol.address import Address
from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.sender_connection import SenderConnection
from conf.protocol.session.client import SenderSession
from conf.protocol.session.events import (
    AddressChanged,
    Connected,
    LossReason,
    NoAnswer,
    Refused,
    SessionEnded,
    WrongCode,
)
from conf.protocol.session.handshake import Refusal
from conf.protocol.session.server import SessionServer
from conf.sender.pipeline import POLL_S, SenderLoop, SenderStatus, describe_event
from conf.transport.interface import ReceivedDatagram

CODE = "amber-canoe-tiger-7"
SENDER, RECEIVER = ("10.0.0.7", 1), ("10.0.0.1", 2)
FAPU = (6.4, 4.5, 3.0, 5.0, 1.1)
PARAMETERS = StreamParameters(176, 144, 15.0, 50, FAPU)


@dataclass
class FakeSocket:
    """A socket with a receiver at its other end, and a clock that advances while the loop waits.

    reachable : whether datagrams arrive
    """

    candidates = ()
    nameplate = ""
    others_wait = False
    receiver: ReceiverEndpoint
    now: float = 0.0
    reachable: bool = True
    waits: list[float] = field(default_factory=list)

    def clock(self) -> float:
        return self.now

    def path_name(self, address: Address) -> str:
        assert address == RECEIVER
        return "direct"

    def send(self, datagrams: list[tuple[bytes, Address]]) -> None:
        for data, _ in datagrams if self.reachable else []:
            self.receiver.receive_datagram(data, SENDER, self.now)

    def receive(self, _limit: int) -> list[ReceivedDatagram]:
        answers = [ReceivedDatagram(data, RECEIVER, 0.0) for data, _ in self.receiver.datagrams_to_send(self.now)]
        return answers if self.reachable else []

    def wait(self, seconds: float) -> None:
        self.waits.append(seconds)
        self.now += max(min(seconds, 0.02), 1e-4)


@dataclass
class FakeSource:
    """A head that turns to and fro before a camera of 30 frames a second.

    has_face : whether there is a face in frame 1, 2, ...
    tracking_s : how long tracking delays the clock
    """

    socket: FakeSocket
    frame_count: int
    has_face: Callable[[int], bool]
    tracking_s: float = 0.0
    frame_number: int = 0
    tracked: list[float] = field(default_factory=list)
    after_sends: list[tuple[float, float]] = field(default_factory=list)  # (timestamp, now)
    calibrated: bool = True
    tracker_ms: float = 4.0
    fapu_lengths: tuple[float, ...] = FAPU
    is_live: bool = True

    def next_frame(self) -> float | None:
        if self.frame_number == self.frame_count:
            return None
        self.frame_number += 1
        return self._timestamp

    def motion(self) -> MotionFrame | None:
        self.socket.now += self.tracking_s
        if not self.has_face(self.frame_number):
            return None
        self.tracked.append(self._timestamp)
        turn = 0.5 * np.sin(self._timestamp * 6)
        pose = np.array([0.0, turn, 0.0, 0.0, 0.0, -3.5])
        return MotionFrame(self._timestamp, np.zeros((50, 3), np.float32), pose)

    def after_send(self, now: float) -> None:
        self.after_sends.append((self._timestamp, now))

    @property
    def _timestamp(self) -> float:
        return (self.frame_number - 1) / 30.0


class Sender:
    """A sending loop, its source and its socket."""

    def __init__(
        self,
        *,
        frames: int = 60,
        code: str = CODE,
        has_face: Callable[[int], bool] = lambda _: True,
        tracking_s: float = 0.0,
        voice: Any = None,
    ) -> None:
        self.receiver = ReceiverEndpoint(SessionServer(CODE, random.Random(1).randbytes))
        self.socket = FakeSocket(self.receiver)
        session = SenderSession(code, RECEIVER, random.Random(2).randbytes, 0.0)
        connection = SenderConnection(session, PARAMETERS, 0.0, rate=RateOptions("live"))
        self.source = FakeSource(self.socket, frames, has_face, tracking_s)
        self.loop = SenderLoop(self.source, connection, self.socket, voice=voice)  # type: ignore[arg-type]

    def run(
        self, *, seconds: float | None = None, on_status: Callable[[SenderStatus], None] | None = None
    ) -> SenderStatus:
        return self.loop.run(seconds=seconds, on_status=on_status, clock=self.socket.clock)


@pytest.mark.slow
def test_a_clip_is_sent_at_its_own_speed_and_the_profiles_frame_rate() -> None:
    sender = Sender(frames=60)
    status = sender.run()
    assert status.frames_captured == 60
    assert status.frames_tracked == pytest.approx(30, abs=1)  # 30 a second reduced to 15
    assert 20 < status.frames_sent <= status.frames_tracked  # frames without motion are not sent
    assert sender.socket.now == pytest.approx(2.0, abs=0.5)
    np.testing.assert_allclose(np.diff(sender.source.tracked), 1 / 15, atol=1e-6)
    assert [timestamp for timestamp, _ in sender.source.after_sends] == sender.source.tracked
    inbound = sender.receiver.report(sender.socket.now)
    assert inbound.frames_received == status.frames_sent and inbound.frames_lost == 0


@pytest.mark.slow
def test_the_receiver_learns_that_there_is_no_face() -> None:
    sender = Sender(frames=90, has_face=lambda frame: frame < 40)
    reported: list[SenderStatus] = []
    status = sender.run(on_status=reported.append)
    assert 0 < status.frames_tracked < 25 and not status.face
    assert {s.face for s in reported if s.frames_tracked} == {True, False}


@pytest.mark.slow
def test_after_the_given_seconds_the_call_is_closed() -> None:
    sender = Sender(frames=10_000)
    sender.run(seconds=1.5)
    assert sender.socket.now == pytest.approx(1.5, abs=0.2)
    assert not sender.receiver.streams


def test_without_an_answer_the_sender_tries_until_the_end_and_then_fails() -> None:
    sender = Sender()
    sender.socket.reachable = False
    notes: list[str] = []
    with pytest.raises(NetworkError, match="nobody answered: start `conf receive` there"):
        sender.run(seconds=8.0, on_status=lambda s: notes.append(s.note))
    assert sender.source.frame_number == 0 and sender.socket.now == pytest.approx(8.0, abs=0.2)
    assert notes[0] == "calling"
    assert notes[-1].startswith("nobody has answered for ") and "is `conf receive` running there" in notes[-1]


@pytest.mark.slow
def test_a_receiver_that_starts_later_is_reached() -> None:
    sender = Sender()
    sender.socket.reachable = False
    notes: list[str] = []

    def start_receiver(status: SenderStatus) -> None:
        notes.append(status.note)
        sender.socket.reachable = sender.socket.now > 4.0

    status = sender.run(on_status=start_receiver)
    assert status.frames_sent > 20 and notes[-1] == "connected"


def test_a_wrong_code_ends_the_call_with_a_message() -> None:
    with pytest.raises(NetworkError, match="the code is wrong: type it as the receiver shows it"):
        Sender(code="acorn-tulip-river-42").run(seconds=20.0)


@pytest.mark.slow
def test_the_status_is_reported_four_times_a_second() -> None:
    reported: list[SenderStatus] = []
    Sender(frames=90).run(on_status=reported.append)
    assert len(reported) == pytest.approx(4 * 3, abs=3)
    assert reported[-1].calibrated and reported[-1].link.connected
    assert reported[-1].wire_bytes_per_frame > 0 and reported[-1].wire_kbps > 0


def test_motion_is_sent_at_the_time_when_tracking_has_ended() -> None:
    sender = Sender(frames=10, tracking_s=0.03)
    starts: list[float] = []
    track = sender.source.motion

    def motion() -> MotionFrame | None:
        starts.append(sender.socket.now)
        return track()

    sender.source.motion = motion  # type: ignore[method-assign]
    sender.run()
    assert [now for _, now in sender.source.after_sends] == pytest.approx([start + 0.03 for start in starts])


def test_step_runs_in_the_loop_of_another_program() -> None:
    sender, now, waits = Sender(frames=30), 100.0, []
    sender.socket.now = now
    while (wait := sender.loop.step(now)) is not None:
        waits.append(wait)
        now += min(wait, 0.01)  # datagrams may end a wait early
        sender.socket.now = now
    assert 0 <= min(waits) <= max(waits) <= POLL_S
    status = sender.loop.status(now)
    assert status.frames_captured == 30 and status.frames_sent > 10 and status.note == "connected"
    assert status.path == "direct"
    assert now == pytest.approx(100 + 29 / 30, abs=3 * POLL_S) and not sender.socket.waits
    assert sender.loop.step(now) is None and sender.receiver.streams
    sender.loop.close(now)
    assert not sender.receiver.streams


@pytest.mark.parametrize(
    ("event", "note"),
    [
        (Connected(1, RECEIVER), "connected"),
        (SessionEnded(1, LossReason.IDLE), "the receiver is gone: calling again"),
        (NoAnswer(5.0), "nobody has answered for 5 s: is `conf receive` running there, of the same version? trying on"),
        (Refused(Refusal.LOCKED, 12.0), "too many wrong codes: the receiver listens again in 12 s"),
        (Refused(Refusal.LOCKED, 255), "too many wrong codes: the receiver listens again in 255 s"),
        (Refused(Refusal.BUSY, 3.0), "the receiver is busy: trying again in 3 s"),
        (Refused(Refusal.IN_CALL, 3.0), "the other end is in a call: trying again in 3 s"),
        (AddressChanged(1, RECEIVER), ""),
    ],
)
def test_session_events_have_a_message(event: object, note: str) -> None:
    assert describe_event(event) == note  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("is_awaited", "note"),
    [
        (False, "nobody waits with the number 4711: is the number right, and the relay the same? trying on"),
        (True, "nobody has answered for 5 s: is `conf receive` running there, of the same version? trying on"),
    ],
)
def test_over_a_relay_it_is_said_whether_somebody_waits(is_awaited: bool, note: str) -> None:
    assert describe_event(NoAnswer(5.0), nameplate="4711", is_awaited=is_awaited) == note


@pytest.mark.parametrize(
    ("nameplate", "text"),
    [("", "the code is wrong: type it as the receiver"), ("4711", r"the words are wrong: .*4711-WORD-WORD-WORD")],
)
def test_a_wrong_code_is_told_as_it_is_typed(nameplate: str, text: str) -> None:
    with pytest.raises(NetworkError, match=text):
        describe_event(WrongCode(4, RECEIVER), nameplate=nameplate)


def test_whom_nobody_answers_over_a_relay_learns_the_number() -> None:
    sender = Sender(frames=30)
    sender.socket.reachable, sender.socket.nameplate = False, "4711"
    with pytest.raises(NetworkError, match="nobody waits with the number 4711: is the number right"):
        sender.loop.run(seconds=0.5, clock=sender.socket.clock)
    assert sender.loop.status(1.0).path == ""
    sender.socket.others_wait = True
    with pytest.raises(NetworkError, match="who waits with the number 4711 has not answered: try again"):
        sender.loop.run(seconds=0.5, clock=sender.socket.clock)


def test_who_was_refused_to_the_end_learns_why() -> None:
    sender = Sender(frames=30)
    events = iter([Refused(Refusal.LOCKED, 50.0)])
    sender.loop._connection.next_event = lambda: next(events, None)  # type: ignore[method-assign]
    sender.socket.reachable = False
    with pytest.raises(NetworkError, match="too many wrong codes: the receiver listens again in 50 s"):
        sender.loop.run(seconds=0.5, clock=sender.socket.clock)


def test_a_full_receiver_ends_the_call_with_a_message() -> None:
    with pytest.raises(NetworkError, match="the receiver has no room for one more caller: try later"):
        describe_event(Refused(Refusal.FULL, None))


@pytest.mark.slow
def test_a_network_failure_that_passes_is_shown_and_survived(monkeypatch: pytest.MonkeyPatch) -> None:
    sender = Sender(frames=240)
    send, notes = sender.socket.send, list[str]()

    def failing(datagrams: list[tuple[bytes, Address]]) -> None:
        if 2.0 < sender.socket.now < 6.0:
            raise NetworkError("nothing can be sent")
        send(datagrams)

    monkeypatch.setattr(sender.socket, "send", failing)
    status = sender.run(on_status=lambda status: notes.append(status.note))
    assert any(re.fullmatch(r"nothing can be sent \(trying for \d+ s more\)", note) for note in notes)
    assert status.note == "connected" and notes[-1] == "connected"


@pytest.mark.slow
def test_a_network_failure_that_lasts_ends_the_call(monkeypatch: pytest.MonkeyPatch) -> None:
    sender = Sender(frames=900)
    send = sender.socket.send

    def failing(datagrams: list[tuple[bytes, Address]]) -> None:
        if sender.socket.now > 2.0:
            raise NetworkError("nothing can be sent")
        send(datagrams)

    monkeypatch.setattr(sender.socket, "send", failing)
    with pytest.raises(NetworkError, match="nothing can be sent"):
        sender.run()
    assert 11.9 < sender.socket.now < 13.0


@pytest.mark.slow
def test_a_camera_that_fails_for_a_moment_is_shown_and_survived(monkeypatch: pytest.MonkeyPatch) -> None:
    sender = Sender(frames=240)
    next_frame, notes = sender.source.next_frame, list[str]()

    def failing() -> float | None:
        if 2.0 < sender.socket.now < 5.0:
            raise CameraError("camera 0 gives no frames any more")
        return next_frame()

    monkeypatch.setattr(sender.source, "next_frame", failing)
    sender.run(on_status=lambda status: notes.append(status.note))
    assert any("camera 0 gives no frames any more (trying for" in note for note in notes)
    assert notes[-1] == "connected"


@dataclass
class BrokenMicrophone:
    """A voice that works for a second. polled : source times"""

    polled: list[float] = field(default_factory=list)
    due_in_s: float = 0.0

    def poll(self, until: float, outlet: object, now: float) -> None:
        self.polled.append(until)
        if until > 1.0:
            raise AudioError("the microphone gives no sound any more")

    def close(self) -> None: ...


@pytest.mark.slow
def test_a_microphone_that_fails_is_said_and_ends_no_call() -> None:
    voice = BrokenMicrophone()
    status = Sender(frames=60, voice=voice).run()
    assert status.frames_captured == 60 and status.note == "the microphone gives no sound any more"
    assert voice.polled[-1] > 1.9  # in case it works again
    assert np.diff(voice.polled).max() < 0.11  # voice never waits longer for a frame
