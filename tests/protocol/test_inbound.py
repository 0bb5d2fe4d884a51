import numpy as np
import pytest

from conf.protocol.inbound import Inbound
from conf.protocol.messages import MotionFrame, Presence, StreamParameters
from conf.protocol.outbound import Outbound
from tests.fakenet import FakeNet

PARAMETERS = StreamParameters(320, 240, 15.0, 50, (6.4, 4.2, 2.0, 5.1, 1.1))
FRAME_S = 1 / 15


def frame(timestamp: float) -> MotionFrame:
    return MotionFrame(timestamp, np.full((50, 3), 10 * timestamp, np.float32), np.array([0, 0, 0, 0, 0, -3.0]))


def call(frames: int, net: FakeNet, inbound: Inbound, begin: float = 100.0) -> Outbound:
    outbound = Outbound(PARAMETERS)
    for i in range(frames):
        now = begin + i * FRAME_S
        outbound.send_frame(frame(i * FRAME_S), now)
        net.send(outbound.datagrams_to_send(now), now)
        for arrival, data in net.arrivals(now):
            inbound.receive_datagram(data, arrival)
    return outbound


def test_a_clean_link_delivers_everything_and_counts_it() -> None:
    inbound = Inbound()
    call(150, FakeNet(), inbound)
    now = 100 + 149 * FRAME_S
    snapshot = inbound.snapshot(now)
    assert (snapshot.frames_received, snapshot.frames_lost, snapshot.frames_late) == (150, 0, 0)
    assert snapshot.fps == pytest.approx(15, rel=0.03)
    assert snapshot.raw_bytes_per_frame == 230_400
    assert 340 < snapshot.wire_bytes_per_frame < 380
    assert snapshot.ratio == pytest.approx(230_400 / snapshot.wire_bytes_per_frame)
    assert snapshot.wire_kbps == pytest.approx(snapshot.wire_bytes_per_frame * 15 * 8 / 1000, rel=0.05)


def test_loss_is_counted_and_playout_goes_on() -> None:
    losses = [i % 4 == 3 for i in range(400)]
    inbound = Inbound()
    outbound = call(150, FakeNet(losses), inbound)
    sent = outbound._sequence
    lost = sum(losses[:sent])
    assert inbound.snapshot(110.0).frames_lost == lost - losses[sent - 1]
    playout = inbound.play(100 + 149 * FRAME_S)
    assert playout is not None and playout.frame.timestamp > 149 * FRAME_S - 0.3


def test_a_receiver_that_joins_late_sees_the_face_within_a_second() -> None:
    inbound = Inbound()
    call(16, FakeNet([True] + [False] * 100), inbound)
    assert inbound.parameters is not None and inbound.parameters.fapu == pytest.approx(PARAMETERS.fapu)
    assert inbound.play(200) is not None


def test_no_face_is_told_once_a_second() -> None:
    outbound, inbound = Outbound(PARAMETERS), Inbound()
    for i in range(150):
        outbound.send_absence(i * FRAME_S, i * FRAME_S)
        for data in outbound.datagrams_to_send(i * FRAME_S):
            inbound.receive_datagram(data, i * FRAME_S)
    assert inbound.presence is Presence.NO_FACE
    assert inbound.snapshot(10).datagrams <= 21
    assert not inbound.silent(10) and inbound.silent(20)


def test_bad_datagrams_are_counted_and_change_nothing() -> None:
    inbound = Inbound()
    call(20, FakeNet(), inbound)
    before = inbound.snapshot(102.0)
    for data in (b"", b"\x00" * 2000, b"\x94\x01\x01\x01", b"hello"):
        inbound.receive_datagram(data, 102.0)
    after = inbound.snapshot(102.0)
    assert after.rejected == before.rejected + 4
    assert after.frames_received == before.frames_received and after.datagrams == before.datagrams
