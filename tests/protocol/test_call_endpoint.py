"""One end of a call of two: what it sends and receives, its figures, and how a call ends and begins again."""

import random
from collections.abc import Callable

import pytest

from conf.protocol.address import Address
from conf.protocol.call_endpoint import CallEndpoint
from conf.protocol.participant.state import CameraState, RemoteState
from conf.protocol.rate_control.rate_levels import VoiceMode
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.session.events import Connected, LossReason, SessionEnded
from conf.protocol.voice.formats import VoicePacket, VoiceState
from tests.support.simulated_call import A, B, Link
from tests.support.simulated_calls import PARAMETERS, talk
from tests.support.simulated_sessions import CODE

BEGIN = 1000.0


def endpoint(seed: str, remote: Address | None = None, *, now: float = BEGIN, voice: bool = False) -> CallEndpoint:
    rate = RateOptions(voice=VoiceMode.AUTOMATIC) if voice else None
    generator = random.Random(seed)
    return CallEndpoint(
        code=CODE, parameters=PARAMETERS, now=now, random=generator.randbytes, remote=remote, rate=rate, name=seed
    )


def connected(*, voice: bool = False) -> tuple[Link[CallEndpoint], CallEndpoint, CallEndpoint]:
    a, b = endpoint("Ada", voice=voice), endpoint("Bob", A, voice=voice)
    link = Link({A: a, B: b}, delays=lambda _: [0.04])
    link.run(1)
    assert len(a.streams) == len(b.streams) == 1
    return link, a, b


def send_frames(*ends: CallEndpoint) -> Callable[[float], None]:
    """Return what sends a frame of each end at each step."""

    def tick(now: float) -> None:
        for end in ends:
            end.send_frame(talk(now), now)

    return tick


@pytest.mark.slow
def test_both_ends_receive_the_motion_of_the_other() -> None:
    link, a, b = connected()
    link.tick = send_frames(a, b)
    link.run(5)
    for end, peer in ((a, B), (b, A)):
        (stream,) = end.streams.values()
        assert stream.motion.frame_at(link.now) is not None
        assert end.snapshot(link.now).frames_received > 40
        report = end.report(link.now)
        assert report.frames_received > 40 and [row.connected for row in report.callers] == [True]
        assert end.status(link.now).connected and end.status(link.now).round_trip_ms == pytest.approx(80, abs=60)
        assert end.callers == {peer}
        assert end.rejected == 0


def test_without_a_call_there_is_nothing() -> None:
    end = endpoint("Ada")
    assert (end.streams, end.callers, end.rejected, end.next_event()) == ({}, set(), 0, None)
    assert end.remote_state == RemoteState("", CameraState.OFF, VoiceState.OFF, None)
    assert end.snapshot(BEGIN).frames_received == end.report(BEGIN).frames_received == 0
    assert end.close(BEGIN) == []


def test_the_state_of_the_other_is_known() -> None:
    link, a, b = connected(voice=True)
    b.send_no_face(link.now, link.now)
    voice_format = a.voice_format
    assert voice_format
    a.send_voice(VoicePacket(link.now, voice_format, (b"a",) * voice_format.frames), link.now)
    link.run(1)
    assert a.remote_state.camera is CameraState.NO_FACE and a.remote_state.voice is VoiceState.OFF
    assert b.remote_state.camera is CameraState.ON and b.remote_state.voice is VoiceState.TALKING


@pytest.mark.slow
@pytest.mark.parametrize("who", range(2))
def test_who_hangs_up_ends_the_call_at_both_ends(who: int) -> None:
    link, *ends = connected()
    leaving, left = ends[who], ends[1 - who]
    link.tick = send_frames(*ends)
    link.run(2)
    for data, address in leaving.close(link.now):
        link.put(data, A if leaving is ends[0] else B, address)
    link.run(10)
    assert [type(e) for e in link.events_of(left)] == [Connected, SessionEnded]
    (first, last) = link.events_of(left)
    assert isinstance(first, Connected) and last == SessionEnded(first.session, LossReason.HUNG_UP)
    assert not leaving.streams and not left.streams
    assert left.rejected == 0, "the second bye is no fault"
    assert not left.status(link.now).connected
    report = left.report(link.now)
    assert report.frames_received > 20 and [row.connected for row in report.callers] == [False]


def test_junk_and_malformed_bodies_are_counted_in_ended_calls_too() -> None:
    link, a, b = connected()
    a.receive_datagram(b"junk", B, link.now)
    sealed = b._call.seal_body(b"\x02junk")
    assert sealed
    a.receive_datagram(sealed.datagram, B, link.now)
    assert a.rejected == a.snapshot(link.now).rejected == 2
    a.close(link.now)
    assert a.rejected == a.report(link.now).rejected == 2


@pytest.mark.slow
def test_a_silent_peer_has_no_rates() -> None:
    link, a, b = connected()
    link.tick = send_frames(b)
    link.run(2)
    del link.ends[B]
    link.tick = lambda now: None
    link.run(4)
    snapshot = a.snapshot(link.now)
    assert snapshot.raw_kbps == snapshot.jitter_ms == snapshot.playout_delay_ms == 0 < snapshot.frames_received


def test_each_call_has_its_own_portrait_receiver() -> None:
    link, a, _ = connected()
    ids = [stream._object_receiver._receiver_id for stream in a.streams.values()]
    link.ends[B] = endpoint("Bob again", A, now=link.now)
    link.run(3)
    ids += [stream._object_receiver._receiver_id for stream in a.streams.values()]
    assert ids == [1, 2]
