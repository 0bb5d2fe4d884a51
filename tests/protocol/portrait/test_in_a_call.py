"""A portrait beside the motion of a whole call, with handshake and seal, without a network."""

import random

import numpy as np
import pytest

from conf.protocol.loopback import LoopbackCall
from conf.protocol.messages import MotionFrame
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.rate_control.send_budget import RateOptions
from tests.protocol.motion.test_outbound import FRAME_S, PARAMETERS, frame

PORTRAIT = bytes(range(256)) * 20


def portrait() -> ObjectSender:
    made = ObjectSender()
    made.send_object(0, PORTRAIT, priority=0)
    return made


def still(timestamp: float) -> MotionFrame:
    return MotionFrame(timestamp, np.zeros((50, 3), np.float32), np.zeros(6))


def connect(rate: RateOptions, objects: ObjectSender | None) -> LoopbackCall:
    return LoopbackCall(PARAMETERS, 0.0, random.Random(1).randbytes, rate=rate, portrait=objects)


def run(seconds: float, rate: RateOptions, objects: ObjectSender | None) -> LoopbackCall:
    call = connect(rate, objects)
    for count in range(round(seconds / FRAME_S)):
        call.send_frame(frame(count * FRAME_S), count * FRAME_S)
    return call


@pytest.mark.slow
def test_the_portrait_arrives_complete_within_seconds_and_costs_no_frame() -> None:
    objects = portrait()
    call = run(6.0, RateOptions("live"), objects)
    assert list(call.stream.received_objects) == [PORTRAIT]
    assert objects.delivered(0)
    without = run(6.0, RateOptions("live"), None)
    assert call.stream.motion.frames.count == without.stream.motion.frames.count


@pytest.mark.slow
def test_on_a_modem_no_portrait_is_sent() -> None:
    assert not run(6.0, RateOptions("narrow"), portrait()).stream.received_objects


@pytest.mark.slow
def test_after_startup_the_budget_holds() -> None:
    objects = portrait()
    for slot in range(1, 20):
        objects.send_object(slot, PORTRAIT, priority=1)
    call = run(45.0, RateOptions("live", portrait_kbps=2.0), objects)
    before = call.wire_bytes
    for count in range(300):
        stamp = 45.0 + count * FRAME_S
        call.send_frame(still(stamp), stamp)
    kbps = (call.wire_bytes - before) * 8 / (300 * FRAME_S) / 1000
    assert 1.5 < kbps < 2.9  # with a keep-alive a second


def test_the_portrait_of_a_still_face_arrives_as_soon() -> None:
    call = connect(RateOptions(), portrait())
    for count in range(90):
        call.send_frame(still(count * FRAME_S), count * FRAME_S)
    assert list(call.stream.received_objects) == [PORTRAIT]
    assert call.wire_bytes * 8 / (90 * FRAME_S) < 16_000


@pytest.mark.slow
def test_under_a_limit_the_portrait_gets_what_the_motion_leaves() -> None:
    received = []
    for objects in (None, portrait()):
        call = run(30.0, RateOptions("live", kbps=7.0), objects)
        assert call.wire_bytes * 8 / 30 < 7_000
        received.append(call.stream.motion.frames.count)
    assert received[1] >= 0.99 * received[0]
