import numpy as np
import pytest

from conf.protocol.loopback import ONE_WAY_S, LoopbackCall
from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.sender_connection import RateOptions
from conf.protocol.statistics import HEADER_BYTES

PARAMETERS = StreamParameters(176, 144, 15.0, 50, (6.4, 4.5, 3.0, 5.0, 1.1))


def frame(i: int) -> MotionFrame:
    rng = np.random.default_rng(i)
    pose = np.array([0.0, 0.3 * np.sin(i / 5), 0.0, 0.0, 0.0, -3.5])
    return MotionFrame(i / 15, rng.normal(0, 20, (50, 3)).astype(np.float32), pose)


def test_every_frame_arrives_and_its_bytes_are_counted() -> None:
    call = LoopbackCall(PARAMETERS, 0.0, link=RateOptions("live"))
    assert call.caller.status(0.0).connected and call.datagrams == call.sealed_bytes == 0
    for i in range(30):
        call.send_frame(frame(i), i / 15)
    traffic = call.inbound.snapshot(2.0)
    assert (
        traffic.frames_received == call.caller.outbound.frames_sent > 25
        and traffic.frames_lost == traffic.rejected == 0
    )
    assert call.wire_bytes == call.sealed_bytes + HEADER_BYTES * call.datagrams
    assert traffic.wire_bytes_per_frame * traffic.frames_received == pytest.approx(call.wire_bytes)


def test_what_is_played_is_what_was_sent_a_way_later() -> None:
    call = LoopbackCall(PARAMETERS, 0.0, link=RateOptions("live"))
    for i in range(15):
        call.send_frame(frame(i), i / 15)
    delay = call.inbound.snapshot(1.0).playout_delay_ms / 1000
    playout = call.inbound.frame_at(14 / 15 + ONE_WAY_S + delay + 1e-3)
    assert playout is not None
    np.testing.assert_allclose(playout.frame.pose, frame(14).pose, atol=0.06)


def test_reports_come_back() -> None:
    call = LoopbackCall(PARAMETERS, 0.0)
    for i in range(45):
        call.send_frame(frame(i), i / 15)
    status = call.caller.status(3.0)
    assert status.round_trip_ms == pytest.approx(2 * ONE_WAY_S * 1000, abs=70)
    assert status.loss_percent == 0
