import numpy as np
import pytest

from conf.protocol.codec import LIVE, NARROWBAND
from conf.protocol.messages import KeepAlive, MotionFrame, MotionPayload, Presence, StreamParameters
from conf.protocol.motion.outbound import OutboundMotion, OutgoingBody
from conf.protocol.wire import decode_body

PARAMETERS = StreamParameters(320, 240, 15.0, 50, (6.4, 4.2, 2.0, 5.1, 1.1))
FRAME_S = 1 / 15
JAW = [0, 2, 7, 8, 9, 10, 11, 37, 42, 43]  # chin and lower lip


def frame(timestamp: float, move: float = 1.0) -> MotionFrame:
    """A face that shakes its head and opens its mouth, or with move 0 a still one."""
    wave = move * np.sin(7 * timestamp)
    displacements = np.zeros((50, 3), np.float32)
    displacements[JAW, 1] = -400 * (1 + wave) * move
    return MotionFrame(timestamp, displacements, np.array([0, 0.4 * wave, 0, 0.02 * wave, 0, -3.3]))


def run(outbound: OutboundMotion, stamps: list[float], move: float = 1.0) -> list[OutgoingBody]:
    sent = []
    for stamp in stamps:
        outbound.send_frame(frame(stamp, move), 100 + stamp)
        sent += outbound.drain()
    return sent


def kinds(sent: list[OutgoingBody]) -> list[type]:
    return [type(decode_body(outgoing.body)) for outgoing in sent]


def test_parameters_are_repeated_until_they_have_arrived() -> None:
    outbound = OutboundMotion(PARAMETERS)
    sent = run(outbound, [i * FRAME_S for i in range(30)])
    assert kinds(sent).count(StreamParameters) == 2 and kinds(sent)[0] is StreamParameters
    outbound.on_sent(7, sent[0])
    outbound.on_acknowledged([7])
    assert StreamParameters not in kinds(run(outbound, [2 + i * FRAME_S for i in range(60)]))


def test_a_still_face_costs_a_keep_alive_a_second() -> None:
    outbound = OutboundMotion(PARAMETERS)
    first = run(outbound, [0.0], move=0)
    for counter, outgoing in enumerate(first):
        outbound.on_sent(counter, outgoing)
    outbound.on_acknowledged([0, 1])
    still = run(outbound, [i * FRAME_S for i in range(1, 150)], move=0)
    assert kinds(still) == [KeepAlive] * 9
    assert decode_body(still[0].body).presence is Presence.FACE


def test_a_still_face_whose_last_motion_was_lost_is_sent_again() -> None:
    outbound = OutboundMotion(PARAMETERS)
    run(outbound, [0.0], move=0)
    again = run(outbound, [i * FRAME_S for i in range(1, 40)], move=0)
    assert MotionPayload in kinds(again)


def test_no_face_is_told_once_a_second() -> None:
    outbound = OutboundMotion(PARAMETERS)
    told = []
    for i in range(150):
        outbound.send_absence(i * FRAME_S, i * FRAME_S)
        told += kinds(outbound.drain())
    assert told.count(KeepAlive) == 10


def test_frames_share_a_datagram_when_the_profile_says_so() -> None:
    outbound = OutboundMotion(PARAMETERS, profile=NARROWBAND)
    sent = run(outbound, [i * FRAME_S for i in range(60)])
    motion = [o for o in sent if o.numbers]
    assert all(len(o.numbers) == NARROWBAND.frames_per_datagram for o in motion)
    numbers = [n for o in motion for n in o.numbers]
    assert numbers == sorted(set(numbers)) and len(numbers) > 50
    outbound.set_profile(LIVE, bundling=2)
    sent = run(outbound, [10 + i * FRAME_S for i in range(60)])
    assert {len(o.numbers) for o in sent if o.numbers} == {2}


def test_prediction_only_from_what_has_arrived() -> None:
    """With acknowledgements a steady motion costs less than without; and never a reference that is not known."""

    def cost(acknowledged: bool) -> int:
        outbound = OutboundMotion(PARAMETERS)
        total = 0
        for i in range(150):
            for counter, outgoing in enumerate(run(outbound, [i * FRAME_S])):
                outbound.on_sent(10 * i + counter, outgoing)
                total += len(outgoing.body) if outgoing.numbers else 0
                if acknowledged:
                    outbound.on_acknowledged([10 * i + counter])
        return total

    assert cost(acknowledged=True) < 0.9 * cost(acknowledged=False)


def test_a_new_session_starts_from_nothing() -> None:
    outbound = OutboundMotion(PARAMETERS)
    for counter, outgoing in enumerate(run(outbound, [0.0])):
        outbound.on_sent(counter, outgoing)
        outbound.on_acknowledged([counter])
    outbound.restart()
    assert kinds(run(outbound, [FRAME_S]))[0] is StreamParameters


@pytest.mark.parametrize("fps", [7, 10, 12.5, 25, 30])
def test_frame_numbers_rise_whatever_the_source_gives(fps: float) -> None:
    sent = run(OutboundMotion(PARAMETERS), [i / fps for i in range(100)])
    numbers = [n for o in sent for n in o.numbers]
    assert numbers == sorted(set(numbers))
    assert len(numbers) == pytest.approx(100 / fps * min(fps, 15), rel=0.05)
