"""One end of a call of two: what it sends and receives, its figures, and how a call ends and begins again."""

import random
from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from conf.protocol.address import Address
from conf.protocol.call_endpoint import CallEndpoint
from conf.protocol.outgoing import OutgoingBody
from conf.protocol.participant.state import CameraState, RemoteState
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.rate_control.rate_levels import VoiceMode
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.session.events import AddressChanged, Connected, LossReason, SessionEnded
from conf.protocol.voice.formats import VoicePacket, VoiceState
from conf.protocol.wire import MOTION_BIT, PARTICIPANT, PORTRAIT_CHUNK, REPORT, ROUND_TRIP, split_bodies
from tests.support.simulated_call import A, B, Link
from tests.support.simulated_calls import PARAMETERS, talk
from tests.support.simulated_sessions import CODE

BEGIN = 1000.0


def endpoint(
    name: str,
    remote: Address | None = None,
    *,
    now: float = BEGIN,
    voice: bool = False,
    portrait: ObjectSender | None = None,
    head: int = 0,
) -> CallEndpoint:
    return CallEndpoint(
        code=CODE,
        parameters=PARAMETERS,
        now=now,
        random=random.Random(name).randbytes,
        remote=remote,
        rate=RateOptions(voice=VoiceMode.AUTOMATIC) if voice else None,
        portrait=portrait,
        name=name,
        head=head,
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


def test_names_are_known_and_cost_nothing_later() -> None:
    link, a, b = connected()
    link.tick = send_frames(a, b)
    link.run(3)
    assert a.remote_state.name == "Bob" and b.remote_state.name == "Ada"
    assert not a._send.participant.is_due(link.now) and not b._send.participant.is_due(link.now)


def kinds_sent(end: CallEndpoint) -> list[int]:
    """Record the kinds of the bodies that an end sends from now on."""
    kinds: list[int] = []
    on_sent = end._leg.on_sent

    def record(counter: int, outgoing: OutgoingBody, now: float) -> None:
        kinds.extend(OutgoingBody(part).kind for part in split_bodies(outgoing.body))
        on_sent(counter, outgoing, now)

    end._leg.on_sent = record  # type: ignore[method-assign]
    return kinds


@pytest.mark.slow
def test_with_the_camera_off_nothing_of_the_face_is_sent_and_the_other_end_knows_it() -> None:
    portrait = ObjectSender()
    portrait.send_object(0, bytes(12000), priority=0)
    a, b = endpoint("Ada", portrait=portrait), endpoint("Bob", A)
    link = Link({A: a, B: b}, delays=lambda _: [0.04])
    link.tick = send_frames(a, b)
    link.run(3)
    assert 0 < (b.remote_state.portrait_percent or 0) < 100
    send_b = send_frames(b)

    def tick(now: float) -> None:
        a.send_camera_off(now)
        send_b(now)

    link.tick = tick
    kinds = kinds_sent(a)
    link.run(0.25)
    assert b.remote_state.camera is CameraState.OFF
    link.run(9)
    assert set(kinds) <= {PARTICIPANT, REPORT, ROUND_TRIP}
    assert 8 <= kinds.count(PARTICIPANT) <= 12, "it is the keep-alive"
    assert a.streams and b.streams and not next(iter(b.streams.values())).is_silent(link.now)
    link.tick = send_frames(a, b)
    link.run(0.3)
    assert b.remote_state.camera is CameraState.ON
    assert MOTION_BIT in kinds and PORTRAIT_CHUNK in kinds


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_who_has_hung_up_is_not_called_again_though_the_first_byes_were_lost(seed: int) -> None:
    link, a, b = connected()
    leaver, other = ((a, b), (b, a))[seed % 2]
    generator, byes = random.Random(seed), leaver.close(link.now)
    assert len(byes) == 2 and leaver.is_leaving(link.now)
    link.delays = lambda _: [0.04] if generator.random() > 0.1 else []
    link.tick = send_frames(other)
    while leaver.is_leaving(link.now):
        link.run(0.05)
    assert [event.reason for event in link.events_of(other) if isinstance(event, SessionEnded)] == [LossReason.HUNG_UP]
    link.run(6)
    assert not other.streams and not leaver.streams
    assert sum(isinstance(event, Connected) for event in link.events_of(leaver)) == 1


@pytest.mark.slow
def test_who_left_unheard_answers_a_peer_that_goes_on_with_a_bye() -> None:
    link, a, b = connected()
    link.delays = lambda _: []
    a.close(link.now)
    link.tick = send_frames(b)
    link.run(1.5)
    assert not a.is_leaving(link.now) and b.streams
    link.delays = lambda _: [0.04]
    link.run(0.5)
    assert isinstance(ended := link.events_of(b)[-1], SessionEnded) and ended.reason is LossReason.HUNG_UP
    link.run(6)
    assert not a.streams and not b.streams


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_camera_that_is_switched_under_heavy_loss_is_known_soon(seed: int) -> None:
    link, a, b = connected(voice=True)
    generator = random.Random(seed)
    link.delays = lambda _: [0.04] if generator.random() > 0.3 else []
    is_off = False

    def tick(now: float) -> None:
        b.send_no_face(now, now)
        if is_off:
            a.send_camera_off(now)
        else:
            a.send_frame(talk(now), now)

    link.tick = tick
    for _ in range(6):
        is_off = not is_off
        link.run(2.5)
        assert b.remote_state == RemoteState("Ada", CameraState.OFF if is_off else CameraState.ON, VoiceState.OFF, None)


@pytest.mark.slow
@pytest.mark.parametrize("who", range(2))
def test_a_move_is_found_within_a_round_trip(who: int) -> None:
    link, *ends = connected()
    link.tick = send_frames(*ends)
    link.run(2)
    moved, other = ends[who], ends[1 - who]
    round_trip = other._send.budget.round_trip
    old, new = (A, B)[who], ("203.0.113.1", 7)
    link.move(old, new)
    began = link.now
    while other.callers != {new}:
        link.run(0.05)
        assert link.now < began + 0.25, "the first frame from there, a way, and a round trip of 80 ms; steps of 50 ms"
    assert other._send.budget.round_trip is not round_trip, "the new path has its own"
    link.run(2)
    assert moved.status(link.now).connected and not next(iter(moved.streams.values())).is_silent(link.now)
    assert AddressChanged(next(iter(other.streams)), new) in link.events_of(other)
    assert [row.caller for row in other.report(link.now).callers] == ["203.0.113.1:7"]


@pytest.mark.slow
def test_both_may_move_at_once_while_their_old_addresses_are_forwarded() -> None:
    link, a, b = connected()
    link.tick = send_frames(a, b)
    link.run(2)
    new_a, new_b = ("203.0.113.1", 7), ("203.0.113.2", 8)
    link.move(A, new_a, is_forwarded=True)
    link.move(B, new_b, is_forwarded=True)
    link.run(0.5)
    assert a.callers == {new_b} and b.callers == {new_a}
    link.forwards.clear()
    link.run(2)
    assert all(not stream.is_silent(link.now) for end in (a, b) for stream in end.streams.values())


@pytest.mark.slow
def test_copies_from_elsewhere_that_overtake_the_originals_lure_nobody_away() -> None:
    link, a, b = connected()
    link.tick = send_frames(a, b)
    elsewhere = ("203.0.113.9", 9)
    for _ in range(40):
        link.run(0.05)
        for _, _, target, data in [sent for sent in link.sent[-6:] if elsewhere not in sent]:
            link.ends[target].receive_datagram(data, elsewhere, link.now)
    assert a.callers == {B} and b.callers == {A}
    to_attacker = sum(len(data) for _, _, target, data in link.sent if target == elsewhere)
    assert 0 < to_attacker < 2 * 24 * 25, "probes"


@pytest.mark.slow
def test_who_called_calls_again_where_the_other_end_has_moved_to() -> None:
    link, a, b = connected()
    link.tick = send_frames(a, b)
    link.run(1)
    new = ("203.0.113.1", 7)
    link.move(A, new)
    link.run(1)
    link.unreachable = {new}
    link.run(40)
    assert not a.streams and not b.streams
    link.unreachable = set()
    link.run(6)
    assert b.callers == {new} and len(a.streams) == 1


FLOW = st.sampled_from(["face", "still", "no face", "camera off", "nothing"])


@pytest.mark.slow
@settings(max_examples=6, phases=[Phase.generate])
@given(flows=st.tuples(FLOW, FLOW), seed=st.integers(0, 99))
@pytest.mark.parametrize("loss", [0.0, 0.1, 0.3])
def test_counters_stay_short_both_ways_and_reports_call_for_no_report(
    loss: float, flows: tuple[str, str], seed: int
) -> None:
    """Whatever each end sends. Two ends with little to say send little: reports do not answer reports."""
    link, *ends = connected()
    generator = random.Random(seed)
    link.delays = lambda _: [0.04] if generator.random() >= loss else []
    senders = [_sender(end, flow) for end, flow in zip(ends, flows, strict=True)]

    def tick(now: float) -> None:
        for send in senders:
            send(now)

    link.tick = tick
    link.run(14)
    data = [(at, datagram) for at, _, _, datagram in link.sent if datagram[0] == 0x94]
    assert all(datagram[3] < 0x80 for _, datagram in data), "a counter of more than one byte"
    late = sum(at > BEGIN + 8 for at, _ in data)
    if "face" not in flows:
        assert late < 7 * 8, "keep-alives or the newest frame again, and a few reports"
    if flows == ("nothing", "nothing"):
        assert late < 10, "a change of the round trip time and its reports"


def _sender(end: CallEndpoint, flow: str) -> Callable[[float], None]:
    return {
        "face": lambda now: end.send_frame(talk(now), now),
        "still": lambda now: end.send_frame(replace(talk(0.0), timestamp=now), now),
        "no face": lambda now: end.send_no_face(now, now),
        "camera off": end.send_camera_off,
        "nothing": lambda now: None,
    }[flow]


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
