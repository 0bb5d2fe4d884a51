import random
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest

from conf.errors import NetworkError
from conf.protocol.address import Address
from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.sender_connection import RateOptions, SenderConnection
from conf.protocol.session.client import SenderSession
from conf.protocol.session.events import AddressChanged, Connected, LossReason, NoAnswer, Refused, SessionEnded
from conf.protocol.session.handshake import Refusal
from conf.protocol.session.server import SessionServer
from conf.sender.pipeline import SenderLoop, SenderStatus, describe_event
from conf.transport.udp import ReceivedDatagram

CODE = "amber-canoe-tiger-7"
SENDER, RECEIVER = ("10.0.0.7", 1), ("10.0.0.1", 2)
FAPU = (6.4, 4.5, 3.0, 5.0, 1.1)
PARAMETERS = StreamParameters(176, 144, 15.0, 50, FAPU)


@dataclass
class FakeLink:
    """A socket with a receiver at its other end, and the clock that goes on while the loop waits or reads a camera.

    there : whether anybody listens
    """

    host: ReceiverEndpoint
    now: float = 0.0
    there: bool = True
    answers: list[tuple[bytes, Address]] = field(default_factory=list)
    times: list[float] = field(default_factory=list)

    def monotonic(self) -> float:
        return self.now

    def send(self, datagrams: list[tuple[bytes, Address]]) -> None:
        for data, _ in datagrams if self.there else []:
            self.times.append(self.now)
            self.host.receive_datagram(data, SENDER, self.now)

    def receive(self) -> list[ReceivedDatagram]:
        answers = [ReceivedDatagram(data, RECEIVER, 0.0) for data, _ in self.host.datagrams_to_send(self.now)]
        return answers if self.there else []

    def wait(self, seconds: float) -> None:
        self.now += max(min(seconds, 0.02), 1e-4)


@dataclass
class FakePerformance:
    """A head that turns to and fro before a camera of 30 pictures a second.

    sees : whether there is a face in the picture of this number, from 1
    """

    count: int
    sees: Callable[[int], bool]
    given: int = 0
    performed: list[float] = field(default_factory=list)
    rested: list[float] = field(default_factory=list)
    calibrated: bool = True
    tracker_ms: float = 4.0
    fapu_lengths: tuple[float, ...] = FAPU

    def next_frame(self) -> float | None:
        if self.given == self.count:
            return None
        self.given += 1
        return self._timestamp

    def motion(self) -> MotionFrame | None:
        if not self.sees(self.given):
            return None
        self.performed.append(self._timestamp)
        turn = 0.5 * np.sin(self._timestamp * 6)
        pose = np.array([0.0, turn, 0.0, 0.0, 0.0, -3.5])
        return MotionFrame(self._timestamp, np.zeros((50, 3), np.float32), pose)

    def after_send(self) -> None:
        self.rested.append(self._timestamp)

    @property
    def _timestamp(self) -> float:
        return (self.given - 1) / 30.0


@dataclass
class Sender:
    """A sending loop with everything around it."""

    loop: SenderLoop
    link: FakeLink
    performance: FakePerformance


Make = Callable[..., Sender]


@pytest.fixture
def make(monkeypatch: pytest.MonkeyPatch) -> Make:
    def build(*, frames: int = 60, code: str = CODE, sees: Callable[[int], bool] = lambda _: True) -> Sender:
        link = FakeLink(ReceiverEndpoint(SessionServer(CODE, random.Random(1).randbytes)))
        monkeypatch.setattr("conf.sender.pipeline.time", link)
        session = SenderSession(code, RECEIVER, random.Random(2).randbytes, 0.0)
        caller = SenderConnection(session, PARAMETERS, 0.0, link=RateOptions("live"))
        performance = FakePerformance(frames, sees)
        loop = SenderLoop(performance, caller, link)  # type: ignore[arg-type]
        return Sender(loop, link, performance)

    return build


def test_a_clip_is_sent_at_its_own_speed_at_the_profiles_pace(make: Make) -> None:
    sender = make(frames=60)
    status = sender.loop.run()
    assert status.frames_captured == 60
    assert status.frames_tracked == pytest.approx(30, abs=1)  # 30 a second thinned to 15
    assert 20 < status.frames_sent <= status.frames_tracked  # a head that stands still costs nothing
    assert sender.link.now == pytest.approx(2.0, abs=0.5)
    np.testing.assert_allclose(np.diff(sender.performance.performed), 1 / 15, atol=1e-6)
    assert sender.performance.rested == sender.performance.performed
    inbound = sender.link.host.snapshot(sender.link.now)
    assert inbound.frames_received == status.frames_sent and inbound.frames_lost == 0


def test_a_face_that_is_not_there_is_told(make: Make) -> None:
    sender = make(frames=90, sees=lambda frame: frame < 40)
    told: list[SenderStatus] = []
    status = sender.loop.run(on_status=told.append)
    assert 0 < status.frames_tracked < 25 and not status.face
    assert {s.face for s in told if s.frames_tracked} == {True, False}


def test_the_time_ends_it_and_the_receiver_hears_goodbye(make: Make) -> None:
    sender = make(frames=10_000)
    sender.loop.run(seconds=1.5)
    assert sender.link.now == pytest.approx(1.5, abs=0.2)
    assert not sender.link.host.streams  # the call is over there too


def test_nobody_there_is_said_and_tried_on_until_the_time_is_over(make: Make) -> None:
    sender = make()
    sender.link.there = False
    notes: list[str] = []
    with pytest.raises(NetworkError, match="nobody answered: start `conf receive` there"):
        sender.loop.run(seconds=8.0, on_status=lambda s: notes.append(s.note))
    assert sender.performance.given == 0 and sender.link.now == pytest.approx(8.0, abs=0.2)
    assert notes[0] == "calling"
    assert notes[-1].startswith("nobody has answered for ") and "is `conf receive` running there" in notes[-1]


def test_a_receiver_that_comes_later_is_reached(make: Make) -> None:
    sender = make()
    sender.link.there = False
    notes: list[str] = []

    def arrive(status: SenderStatus) -> None:
        notes.append(status.note)
        sender.link.there = sender.link.now > 4.0

    status = sender.loop.run(on_status=arrive)
    assert status.frames_sent > 20 and notes[-1] == "connected"


def test_a_wrong_code_ends_the_call_with_a_sentence(make: Make) -> None:
    sender = make(code="acorn-tulip-river-42")
    with pytest.raises(NetworkError, match="the code is wrong: type it as the receiver shows it"):
        sender.loop.run(seconds=20.0)


def test_status_is_told_four_times_a_second(make: Make) -> None:
    told: list[SenderStatus] = []
    make(frames=90).loop.run(on_status=told.append)
    assert len(told) == pytest.approx(4 * 3, abs=3)
    assert told[-1].calibrated and told[-1].link.connected
    assert told[-1].wire_bytes_per_frame > 0 and told[-1].wire_kbps > 0


@pytest.mark.parametrize(
    ("event", "note"),
    [
        (Connected(1, RECEIVER), "connected"),
        (SessionEnded(1, LossReason.IDLE), "the receiver is gone: calling again"),
        (NoAnswer(5.0), "nobody has answered for 5 s: is `conf receive` running there, of the same version? trying on"),
        (Refused(Refusal.LOCKED, 12.0), "too many wrong codes: the receiver listens again in 12 s"),
        (Refused(Refusal.BUSY, 3.0), "the receiver is busy: trying again in 3 s"),
        (AddressChanged(1, RECEIVER), ""),
    ],
)
def test_what_events_mean(event: object, note: str) -> None:
    assert describe_event(event) == note  # type: ignore[arg-type]


def test_a_receiver_without_room_ends_the_call_with_a_sentence() -> None:
    with pytest.raises(NetworkError, match="the receiver has no room for one more caller: try later"):
        describe_event(Refused(Refusal.FULL, None))
