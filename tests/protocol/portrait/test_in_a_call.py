"""A picture under the motion of a whole call: caller and host, handshake and seal, without a network."""

import numpy as np

from conf.protocol.loopback import LoopbackCall
from conf.protocol.messages import MotionFrame
from conf.protocol.portrait import ObjectSender
from conf.protocol.sender_connection import RateOptions
from tests.protocol.motion.test_outbound import FRAME_S, PARAMETERS, frame

PICTURE = bytes(range(256)) * 20


def call(seconds: float, profile: str, outbox: ObjectSender | None) -> LoopbackCall:
    rehearsal = LoopbackCall(PARAMETERS, 0.0, link=RateOptions(profile), portrait=outbox)
    for count in range(round(seconds / FRAME_S)):
        rehearsal.send_frame(frame(count * FRAME_S), count * FRAME_S)
    return rehearsal


def outbox_with_a_picture(kbps: float = 4.0) -> ObjectSender:
    outbox = ObjectSender(kbps=kbps)
    outbox.send_object(0, PICTURE, priority=0)
    return outbox


def test_the_picture_arrives_whole_within_seconds_and_costs_no_frame() -> None:
    outbox = outbox_with_a_picture()
    rehearsal = call(6.0, "live", outbox)
    assert list(rehearsal.inbound.received_objects) == [PICTURE]
    assert outbox.delivered(0)
    without = call(6.0, "live", None)
    assert rehearsal.inbound.frames.count == without.inbound.frames.count


def test_a_modem_is_left_to_the_motion() -> None:
    assert not call(6.0, "narrow", outbox_with_a_picture()).inbound.received_objects


def test_after_the_start_the_budget_holds() -> None:
    outbox = outbox_with_a_picture(kbps=2.0)
    for slot in range(1, 20):
        outbox.send_object(slot, PICTURE, priority=1)
    rehearsal = call(45.0, "live", outbox)
    assert not outbox.in_startup
    before = rehearsal.wire_bytes
    for count in range(300):
        stamp = 45.0 + count * FRAME_S
        rehearsal.send_frame(MotionFrame(stamp, np.zeros((50, 3), np.float32), np.zeros(6)), stamp)
    kbps = (rehearsal.wire_bytes - before) * 8 / (300 * FRAME_S) / 1000
    assert 1.5 < kbps < 2.9  # a still face beside it costs a keep-alive a second


def test_a_still_face_does_not_keep_its_picture_waiting() -> None:
    outbox = outbox_with_a_picture()
    rehearsal = LoopbackCall(PARAMETERS, 0.0, portrait=outbox)
    for count in range(90):
        stamp = count * FRAME_S
        rehearsal.send_frame(MotionFrame(stamp, np.zeros((50, 3), np.float32), np.zeros(6)), stamp)
    assert list(rehearsal.inbound.received_objects) == [PICTURE]
    assert rehearsal.wire_bytes * 8 / (90 * FRAME_S) < 16_000


def test_under_a_cap_the_picture_takes_only_what_the_motion_leaves() -> None:
    frames = [frame(count * FRAME_S) for count in range(450)]
    received = []
    for portrait in (None, outbox_with_a_picture()):
        rehearsal = LoopbackCall(PARAMETERS, 0.0, link=RateOptions("live", kbps=7.0), portrait=portrait)
        for moment in frames:
            rehearsal.send_frame(moment, moment.timestamp)
        assert rehearsal.wire_bytes * 8 / 30 < 7_000
        received.append(rehearsal.inbound.frames.count)
    assert received[1] >= 0.99 * received[0]
