import random

import numpy as np
import pytest

from conf.protocol.loopback import ONE_WAY_S, LoopbackCall
from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.statistics import HEADER_BYTES

PARAMETERS = StreamParameters(176, 144, 15.0, 50, (6.4, 4.5, 3.0, 5.0, 1.1))


def frame(i: int) -> MotionFrame:
    rng = np.random.default_rng(i)
    pose = np.array([0.0, 0.3 * np.sin(i / 5), 0.0, 0.0, 0.0, -3.5])
    return MotionFrame(i / 15, rng.normal(0, 20, (50, 3)).astype(np.float32), pose)


def call(frames: int, profile: str = "live") -> LoopbackCall:
    made = LoopbackCall(PARAMETERS, 0.0, random.Random(1).randbytes, rate=RateOptions(profile))
    assert made.sender.status(0.0).connected and made.datagrams == made.sealed_bytes == 0
    for i in range(frames):
        made.send_frame(frame(i), i / 15)
    return made


@pytest.mark.slow
def test_every_frame_arrives_and_its_bytes_are_counted() -> None:
    made = call(30)
    traffic = made.stream.snapshot(2.0)
    assert traffic.frames_received == made.sender.outbound.frames_sent > 25
    assert traffic.frames_lost == traffic.rejected == 0
    assert made.wire_bytes == made.sealed_bytes + HEADER_BYTES * made.datagrams
    assert traffic.wire_bytes_per_frame * traffic.frames_received == pytest.approx(made.wire_bytes)


def test_the_motion_is_played_out_one_way_later() -> None:
    made = call(15)
    delay = made.stream.snapshot(1.0).playout_delay_ms / 1000
    playout = made.stream.motion.frame_at(14 / 15 + ONE_WAY_S + delay + 1e-3)
    assert playout is not None
    np.testing.assert_allclose(playout.frame.pose, frame(14).pose, atol=0.06)


@pytest.mark.slow
def test_reports_come_back() -> None:
    status = call(45, "auto").sender.status(3.0)
    assert status.round_trip_ms == pytest.approx(2 * ONE_WAY_S * 1000, abs=70)
    assert status.loss_percent == 0


@pytest.mark.slow
def test_the_rate_is_applied_and_the_portrait_arrives() -> None:
    portrait = ObjectSender()
    portrait.send_object(0, bytes(range(200)), priority=0)
    made = LoopbackCall(PARAMETERS, 0.0, random.Random(1).randbytes, rate=RateOptions("live", 100.0), portrait=portrait)
    for i in range(30):
        made.send_frame(frame(i), i / 15)
    assert list(made.stream.received_objects) == [bytes(range(200))]
    assert call(1, "rich").sender.status(1.0).profile == "rich"
