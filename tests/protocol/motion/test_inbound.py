import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conf.protocol.codec import LIVE, NARROWBAND, RICH, Profile
from conf.protocol.messages import Feedback, Presence
from conf.protocol.motion.inbound import InboundMotion
from conf.protocol.motion.outbound import OutboundMotion
from conf.protocol.wire import decode_body
from tests.protocol.motion.test_outbound import PARAMETERS, frame

OVERHEAD = 42
WRONG = 0.25  # radians: an interpolation over losses may be off by the motion's own bend, a wrong frame by up to 0.8


class Call:
    """Outbound and Inbound joined by a lossy link without a seal: a list of losses, reports each half second."""

    def __init__(self, profile: Profile = LIVE, delay: float = 0.05) -> None:
        self.outbound = OutboundMotion(PARAMETERS, profile=profile)
        self.inbound = InboundMotion()
        self.delay = delay
        self.counter = 0
        self.errors: list[float] = []
        self._reports: list[tuple[float, bytes]] = []

    def run(self, frames: int, lost: list[bool], begin: float = 0.0, *, fps: float = 15) -> None:
        for i in range(frames):
            stamp = begin + i / fps
            now = 100 + stamp
            for arrival, report in [r for r in self._reports if r[0] <= now]:
                self._reports.remove((arrival, report))
                feedback = decode_body(report)
                assert isinstance(feedback, Feedback)
                if feedback.refresh:
                    self.outbound.drop_references()
                self.outbound.on_acknowledged(feedback.report.acknowledged())
            self.outbound.send_frame(frame(stamp), now)
            for outgoing in self.outbound.drain():
                self.outbound.on_sent(self.counter, outgoing)
                if not (lost[self.counter % len(lost)] if lost else False):
                    size = len(outgoing.body) + OVERHEAD
                    self.inbound.receive_body(outgoing.body, self.counter, size, now + self.delay)
                self.counter += 1
            report = self.inbound.feedback(now + self.delay)
            if report:
                self._reports.append((now + 2 * self.delay, report))
            self._compare(now + self.delay)

    def _compare(self, now: float) -> None:
        playout = self.inbound.frame_at(now)
        if playout and playout.age_s == 0:
            truth = frame(playout.frame.timestamp)
            self.errors.append(float(abs(playout.frame.pose[1] - truth.pose[1])))


def test_a_clean_link_delivers_everything_and_counts_it() -> None:
    call = Call()
    call.run(150, [])
    snapshot = call.inbound.snapshot(100 + 10 + call.delay)
    assert (snapshot.frames_received, snapshot.frames_lost) == (call.outbound.frames_sent, 0)
    assert snapshot.frames_received > 140 and snapshot.frames_late == 0
    assert snapshot.fps == pytest.approx(14.5, rel=0.05)
    assert snapshot.raw_bytes_per_frame == 230_400
    assert 43 < snapshot.wire_bytes_per_frame < 60
    assert snapshot.ratio == pytest.approx(230_400 / snapshot.wire_bytes_per_frame)


@settings(max_examples=15)
@given(st.lists(st.booleans(), min_size=5, max_size=40), st.sampled_from([LIVE, NARROWBAND, RICH]))
def test_whatever_is_lost_no_wrong_frame_is_shown(losses: list[bool], profile: Profile) -> None:
    call = Call(profile)
    call.run(120, losses, fps=profile.fps)
    assert call.inbound.rejected <= call.counter
    assert not call.inbound.missed_references
    assert max(call.errors, default=0.0) < WRONG


def test_loss_is_counted_and_playout_goes_on() -> None:
    losses = [i % 4 == 3 for i in range(40)]
    call = Call()
    call.run(150, losses)
    snapshot = call.inbound.snapshot(110)
    assert snapshot.frames_lost == pytest.approx(150 / 4, abs=3)
    playout = call.inbound.frame_at(110.05)
    assert playout is not None and playout.frame.timestamp > 9.7


def test_a_receiver_that_joins_late_sees_the_face_within_a_second() -> None:
    call = Call()
    call.run(45, [True])
    call.run(20, [], begin=3.0)
    assert call.inbound.parameters is not None
    assert call.inbound.frame_at(110) is not None


def test_frame_numbers_survive_an_outage_of_any_length() -> None:
    call = Call()
    call.run(30, [])
    call.run(15 * 20, [True], begin=2.0)
    call.errors.clear()
    call.run(30, [], begin=22.0)
    playout = call.inbound.frame_at(100 + 24)
    assert playout is not None and playout.frame.timestamp == pytest.approx(24, abs=0.3)
    assert max(call.errors[3:]) < WRONG


def test_no_face_is_shown_as_such() -> None:
    outbound, inbound = OutboundMotion(PARAMETERS), InboundMotion()
    outbound.send_absence(0.0, 0.0)
    for counter, outgoing in enumerate(outbound.drain()):
        inbound.receive_body(outgoing.body, counter, 60, 0.0)
    assert inbound.presence is Presence.NO_FACE
    assert not inbound.is_silent(1) and inbound.is_silent(20)


@given(st.lists(st.binary(max_size=40), max_size=20))
def test_bad_bodies_are_counted_and_never_raise(bodies: list[bytes]) -> None:
    call = Call()
    call.run(5, [])
    before = call.inbound.snapshot(101).frames_received
    for counter, body in enumerate(bodies):
        call.inbound.receive_body(bytes([0x7F]) + body, 100 + counter, 60, 101)
    assert call.inbound.rejected == len(bodies)
    assert call.inbound.snapshot(101).frames_received == before


def test_a_missing_reference_is_asked_for_and_never_guessed() -> None:
    call = Call()
    call.run(30, [])
    fresh = InboundMotion()
    call.inbound = fresh
    call.outbound._arrived = None  # the new receiver gets the parameters, and motion predicted from what it never had
    call.run(30, [], begin=2.0)
    assert fresh.missed_references
    assert fresh.snapshot(105).frames_received > 10
    assert max(call.errors) < WRONG
