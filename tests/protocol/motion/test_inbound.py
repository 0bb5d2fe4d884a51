from dataclasses import replace

import pytest

from conf.errors import ProtocolError
from conf.protocol.codec.encoder import Encoder
from conf.protocol.codec.profiles import LIVE, RICH, Profile
from conf.protocol.messages import FurrowMessage, KeepAlive, MotionPayload, Presence
from conf.protocol.motion.inbound import InboundMotion
from tests.protocol.motion.test_outbound import PARAMETERS, frame


def payload(number: int, profile: Profile = LIVE) -> MotionPayload:
    """Return one frame without prediction. number : unwrapped"""
    encoded = Encoder(profile).encode([frame(number / profile.fps)], number)
    return MotionPayload(number & 0x7F, encoded)


def test_motion_is_played_out_at_its_time() -> None:
    inbound = InboundMotion()
    inbound.receive_parameters(PARAMETERS, 100.0)
    assert inbound.parameters is PARAMETERS and inbound.frame_at(100.0) is None
    for number in range(15):
        assert inbound.receive_motion(payload(number), 100 + number / 15) == number / 15
    assert (inbound.datagrams, inbound.frames.count) == (15, 15)
    assert [received.frame.timestamp for received in inbound.received] == [number / 15 for number in range(15)]
    assert {received.fps for received in inbound.received} == {15}
    playout = inbound.frame_at(100 + 14 / 15 + inbound.buffer.clock.delay_s)
    assert playout is not None
    assert playout.frame.timestamp == pytest.approx(14 / 15)
    assert playout.frame.pose == pytest.approx(frame(14 / 15).pose, abs=0.05)


@pytest.mark.parametrize("profile", [LIVE, RICH])
@pytest.mark.parametrize("outage_s", [1, 4, 7, 60, 3600])
def test_frame_numbers_are_unwrapped_by_the_clock_after_an_outage(profile: Profile, outage_s: int) -> None:
    inbound = InboundMotion()
    inbound.receive_motion(payload(10, profile), 100 + 10 / profile.fps)
    number = round(outage_s * profile.fps)
    arrival = 100 + outage_s + 1.2  # later than expected, but within half of the 128 numbers
    assert inbound.receive_motion(payload(number, profile), arrival) == outage_s


def test_the_first_frames_need_no_clock_and_parameters_set_it() -> None:
    assert InboundMotion().receive_motion(payload(100), 5.0) == pytest.approx(100 / 15)
    inbound = InboundMotion()
    inbound.receive_parameters(replace(PARAMETERS, clock=60.0), 5.0)
    assert inbound.receive_motion(payload(910), 6.0) == pytest.approx(910 / 15)
    inbound = InboundMotion()
    inbound.receive_keep_alive(KeepAlive(60.0, Presence.NO_FACE), 5.0)
    assert inbound.receive_motion(payload(920), 6.0) == pytest.approx(920 / 15)


def test_an_older_frame_does_not_set_the_clock_back() -> None:
    inbound = InboundMotion()
    inbound.receive_motion(payload(60), 104.0)
    inbound.receive_motion(payload(20), 104.0)
    assert inbound._clock.time(104.0) == 4.0


def test_presence_follows_keep_alives_and_motion() -> None:
    inbound = InboundMotion()
    assert inbound.presence is Presence.FACE
    inbound.receive_keep_alive(KeepAlive(0.0, Presence.NO_FACE), 100.0)
    assert inbound.presence is Presence.NO_FACE
    inbound.receive_motion(payload(1), 100.1)
    assert inbound.presence is Presence.FACE
    inbound.receive_keep_alive(KeepAlive(1.0, Presence.NO_FACE), 101.0)
    assert inbound.presence is Presence.NO_FACE and inbound.buffer.newest == pytest.approx(1 / 15)
    inbound.receive_keep_alive(KeepAlive(2.0, Presence.FACE), 102.0)
    assert inbound.presence is Presence.FACE and inbound.buffer.newest == 2.0


def test_a_bad_payload_raises_and_changes_nothing() -> None:
    inbound = InboundMotion()
    with pytest.raises(ProtocolError):
        inbound.receive_motion(MotionPayload(5, b"\xff" * 3), 1.0)
    assert (inbound.datagrams, inbound.frames.count, inbound.buffer.newest, inbound._clock.time(2.0)) == (
        0,
        0,
        None,
        None,
    )


def test_furrows_hold_from_their_datagram_on_until_a_newer_one_tells_others() -> None:
    inbound = InboundMotion()
    inbound.receive_motion(payload(0), 100.0)
    for number, counter, level in ((1, 5, 7), (2, 7, 0), (3, 6, 3)):
        inbound.receive_furrows(FurrowMessage(level), counter)
        inbound.receive_motion(payload(number), 100 + number / 15)
    assert [received.frame.furrow for received in inbound.received] == [0, 1, 0, 0], "counter 6 came too late"
