from dataclasses import replace
from itertools import chain

import numpy as np
import pytest

from conf.protocol.codec.decoder import Decoder
from conf.protocol.codec.profiles import LIVE, NARROWBAND, RICH
from conf.protocol.messages import FurrowMessage, KeepAlive, MotionFrame, MotionPayload, Presence, StreamParameters
from conf.protocol.motion.furrow_announcer import FURROW_BYTES
from conf.protocol.motion.outbound import (
    FAPU_TOLERANCE,
    MAX_IN_FLIGHT,
    REPEAT_S,
    SMOOTHING,
    SQUEEZE,
    UNCONFIRMED_S,
    OutboundMotion,
)
from conf.protocol.outgoing import OutgoingBody
from conf.protocol.wire import decode_body

PARAMETERS = StreamParameters(320, 240, 15.0, 50, (6.4, 4.2, 2.0, 5.1, 1.1))
FRAME_S = 1 / 15
JAW = [0, 2, 7, 8, 9, 10, 11, 37, 42, 43]  # chin and lower lip


def frame(timestamp: float, move: float = 1.0) -> MotionFrame:
    """Return a face that shakes its head and opens its mouth, or with move 0 a still one."""
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


def acknowledge(outbound: OutboundMotion, sent: list[OutgoingBody]) -> None:
    for counter, outgoing in enumerate(sent):
        outbound.on_sent(counter, outgoing)
    outbound.on_acknowledged(range(len(sent)))


def kinds(sent: list[OutgoingBody]) -> list[type]:
    return [type(decode_body(outgoing.body)) for outgoing in sent]


def frames(count: int, begin: float = 0.0) -> list[float]:
    return [begin + i * FRAME_S for i in range(count)]


def test_parameters_are_repeated_each_second_until_acknowledged() -> None:
    outbound = OutboundMotion(PARAMETERS)
    sent = run(outbound, frames(30))
    assert kinds(sent).count(StreamParameters) == 2 and kinds(sent)[0] is StreamParameters
    assert decode_body(sent[0].body) == replace(PARAMETERS, clock=0.0)
    outbound.on_sent(7, sent[0])
    outbound.on_acknowledged([6, 7])
    assert StreamParameters not in kinds(run(outbound, frames(60, 2.0)))


@pytest.mark.parametrize(
    ("changed", "is_sent"),
    [
        (PARAMETERS, False),
        (replace(PARAMETERS, width=640), True),
        (replace(PARAMETERS, fapu=(6.4 * (1 + 0.9 * FAPU_TOLERANCE), *PARAMETERS.fapu[1:])), False),
        (replace(PARAMETERS, fapu=(6.4 * (1 - 0.9 * FAPU_TOLERANCE), *PARAMETERS.fapu[1:])), False),
        (replace(PARAMETERS, fapu=(6.4 * (1 + 1.1 * FAPU_TOLERANCE), *PARAMETERS.fapu[1:])), True),
        (replace(PARAMETERS, fapu=(*PARAMETERS.fapu[:-1], 1.2)), True),
    ],
)
def test_acknowledged_parameters_are_sent_again_only_if_they_change(changed: StreamParameters, is_sent: bool) -> None:
    outbound = OutboundMotion(PARAMETERS)
    acknowledge(outbound, run(outbound, frames(1)))
    outbound.parameters = changed
    assert (StreamParameters in kinds(run(outbound, frames(20, 2.0)))) == is_sent


def test_parameters_carry_the_profiles_frame_rate_and_the_stream_clock() -> None:
    outbound = OutboundMotion(PARAMETERS, profile=RICH)
    run(outbound, [50.0])
    (parameters,) = [decode_body(o.body) for o in run(outbound, [51.25]) if o.parameters]
    assert isinstance(parameters, StreamParameters)
    assert (parameters.fps, parameters.clock) == (RICH.fps, 1.25)


def test_a_still_face_costs_a_keep_alive_a_second() -> None:
    outbound = OutboundMotion(PARAMETERS)
    acknowledge(outbound, run(outbound, [0.0], move=0))
    still = run(outbound, frames(150)[1:], move=0)
    assert kinds(still) == [KeepAlive] * 9
    assert decode_body(still[0].body) == KeepAlive(1.0, Presence.FACE)


def test_a_still_face_whose_last_motion_was_lost_is_sent_again() -> None:
    outbound = OutboundMotion(PARAMETERS)
    run(outbound, [0.0], move=0)
    again = run(outbound, frames(40)[1:], move=0)
    bodies = [decode_body(outgoing.body) for outgoing in again]
    times = [body.frame_number * FRAME_S for body in bodies if isinstance(body, MotionPayload)]
    assert times == pytest.approx([UNCONFIRMED_S, UNCONFIRMED_S + REPEAT_S, UNCONFIRMED_S + 2 * REPEAT_S], abs=0.07)


def test_a_still_face_whose_last_motion_a_report_shows_lost_is_sent_again_at_once() -> None:
    still = frames(4, 0.1)
    outbound = OutboundMotion(PARAMETERS)
    acknowledge(outbound, run(outbound, [0.0], move=0))
    (lost,) = run(outbound, [FRAME_S], move=0.3)
    outbound.on_sent(8, lost)
    moved = frame(FRAME_S, 0.3)
    for stamp, acknowledged, expected in zip(
        still, ([7], [], [7, 9], [7, 9]), ([], [], [MotionPayload], []), strict=True
    ):
        outbound.on_acknowledged(acknowledged)
        outbound.send_frame(replace(moved, timestamp=stamp), 100 + stamp)
        assert kinds(outbound.drain()) == expected


def test_no_face_is_reported_once_a_second() -> None:
    outbound = OutboundMotion(PARAMETERS)
    reported = []
    for stamp in frames(150):
        outbound.send_no_face(stamp, stamp)
        reported += outbound.drain()
    assert kinds(reported).count(KeepAlive) == 10
    assert decode_body(reported[1].body) == KeepAlive(0.0, Presence.NO_FACE)


def test_frames_that_wait_are_sent_before_no_face() -> None:
    outbound = OutboundMotion(PARAMETERS)
    outbound.set_profile(LIVE, bundling=3)
    assert not [o for o in run(outbound, frames(2)) if o.frame_numbers]
    outbound.send_no_face(2 * FRAME_S, 5.0)
    assert [o.frame_numbers for o in outbound.drain() if o.frame_numbers] == [(0, 1)]


def test_a_probe_is_a_keep_alive() -> None:
    outbound = OutboundMotion(PARAMETERS)
    run(outbound, [10.0])
    assert decode_body(outbound.probe(12.5).body) == KeepAlive(2.5, Presence.FACE)
    assert decode_body(outbound.probe(9.0).body) == KeepAlive(0.0, Presence.FACE)


@pytest.mark.slow
def test_frames_share_a_datagram_if_the_profile_or_the_bundling_asks_for_it() -> None:
    outbound = OutboundMotion(PARAMETERS, profile=NARROWBAND)
    motion = [o for o in run(outbound, frames(60)) if o.frame_numbers]
    assert all(len(o.frame_numbers) == NARROWBAND.frames_per_datagram for o in motion)
    numbers = [n for o in motion for n in o.frame_numbers]
    assert numbers == sorted(set(numbers)) and len(numbers) > 50
    outbound.set_profile(LIVE, bundling=2)
    bundled = [o.frame_numbers for o in run(outbound, frames(60, 10.0)) if o.frame_numbers]
    waiting = bundled[0] if bundled[0][0] < 60 else ()  # it was to go with frames that the profile before grouped
    assert {len(group) for group in bundled if group != waiting} == {2}


def test_uneven_steps_are_not_put_in_one_datagram() -> None:
    outbound = OutboundMotion(PARAMETERS)
    outbound.set_profile(LIVE, bundling=3)
    stamps = [n * FRAME_S for n in (0, 1, 3, 5, 7, 8, 30, 31, 32)]
    sent = [o.frame_numbers for o in run(outbound, stamps) if o.frame_numbers]
    assert sent == [(0, 1), (3, 5, 7), (8,), (30, 31, 32)]
    assert outbound.frames_sent == 9


def test_a_frame_that_is_not_newer_is_dropped() -> None:
    outbound = OutboundMotion(PARAMETERS)
    numbers = [n for o in run(outbound, [0.0, 0.2, 0.1, 0.2, 0.21, 0.3]) for n in o.frame_numbers]
    assert numbers == [0, 3, 4]


def test_a_new_profile_continues_the_stream_in_its_own_numbers() -> None:
    outbound = OutboundMotion(PARAMETERS, profile=LIVE)
    run(outbound, frames(31))
    outbound.set_profile(RICH)
    numbers = [n for o in run(outbound, [2.0, 2.0 + 1 / 30, 2.0 + 2 / 30]) for n in o.frame_numbers]
    assert outbound.profile is RICH and numbers == [61, 62]


def test_frames_that_wait_are_sent_before_the_profile_changes() -> None:
    outbound = OutboundMotion(PARAMETERS)
    outbound.set_profile(LIVE, bundling=2)
    run(outbound, frames(1))
    outbound.set_profile(LIVE, bundling=2)
    assert not outbound.drain()
    outbound.set_profile(RICH)
    assert [o.frame_numbers for o in outbound.drain()] == [(0,)]


@pytest.mark.slow
def test_motion_is_predicted_only_from_acknowledged_frames() -> None:
    """With acknowledgements a steady motion costs less than without."""

    def cost(acknowledged: bool) -> int:
        outbound = OutboundMotion(PARAMETERS)
        total = 0
        for i in range(150):
            for counter, outgoing in enumerate(run(outbound, [i * FRAME_S])):
                outbound.on_sent(10 * i + counter, outgoing)
                total += len(outgoing.body) if outgoing.frame_numbers else 0
                if acknowledged:
                    outbound.on_acknowledged([10 * i + counter])
        return total

    assert cost(acknowledged=True) < 0.9 * cost(acknowledged=False)


def test_dropped_references_are_not_used_even_if_acknowledged_later() -> None:
    outbound = OutboundMotion(PARAMETERS)
    fresh = OutboundMotion(PARAMETERS)
    for counter, outgoing in enumerate(run(outbound, frames(10))):
        outbound.on_sent(counter, outgoing)
    run(fresh, frames(10))
    outbound.drop_references()
    outbound.on_acknowledged(range(100))
    later = [[o.body for o in run(side, frames(3, 1.0)) if o.frame_numbers] for side in (outbound, fresh)]
    assert later[0] == later[1]


def test_memory_of_sent_datagrams_is_bounded() -> None:
    outbound = OutboundMotion(PARAMETERS)
    for counter in range(2 * MAX_IN_FLIGHT):
        outbound.on_sent(counter, OutgoingBody(b""))
    assert list(outbound._in_flight) == list(range(MAX_IN_FLIGHT, 2 * MAX_IN_FLIGHT))


def test_a_new_session_starts_from_nothing() -> None:
    stamps = [102.0, 102.0 + 1 / 30]
    outbound = OutboundMotion(PARAMETERS, profile=RICH)
    acknowledge(outbound, run(outbound, [100.0, 100.0 + 1 / 30]))
    run(outbound, [101.0])
    outbound.restart()
    assert outbound.profile is RICH
    sent = run(outbound, stamps)
    assert kinds(sent) == [StreamParameters, MotionPayload] and sent[1].frame_numbers == (0, 1)
    assert [o.body for o in sent] == [o.body for o in run(OutboundMotion(PARAMETERS, profile=RICH), stamps)]


@pytest.mark.slow
@pytest.mark.parametrize("fps", [7, 10, 12.5, 25, 30])
def test_frame_numbers_rise_whatever_the_source_gives(fps: float) -> None:
    sent = run(OutboundMotion(PARAMETERS), [i / fps for i in range(100)])
    numbers = [n for o in sent for n in o.frame_numbers]
    assert numbers == sorted(set(numbers))
    assert len(numbers) == pytest.approx(100 / fps * min(fps, 15), rel=0.05)


def motion_of(outbound: OutboundMotion) -> list[OutgoingBody]:
    return [outgoing for outgoing in outbound.drain() if outgoing.frame_numbers]


def test_frames_that_wait_leave_at_the_flush_however_many() -> None:
    outbound = OutboundMotion(PARAMETERS)
    outbound.wait_for_flush(True)
    assert not [o for o in run(outbound, frames(5)) if o.frame_numbers]
    outbound.flush()
    assert [o.frame_numbers for o in outbound.waiting if o.frame_numbers] == [(0, 1, 2, 3, 4)]
    assert [o.frame_numbers for o in motion_of(outbound)] == [(0, 1, 2, 3, 4)]
    outbound.flush()
    assert not outbound.drain()
    assert [o.frame_numbers for o in run(outbound, frames(9, 1.0)) if o.frame_numbers] == [tuple(range(15, 23))]


def test_frames_that_need_no_longer_wait_leave_if_they_fill_a_datagram() -> None:
    outbound = OutboundMotion(PARAMETERS, profile=NARROWBAND)
    outbound.wait_for_flush(True)
    run(outbound, frames(2))
    outbound.wait_for_flush(False)
    assert motion_of(outbound) == []
    outbound.wait_for_flush(True)
    run(outbound, frames(2, 2 * FRAME_S))
    outbound.wait_for_flush(False)
    assert [o.frame_numbers for o in motion_of(outbound)] == [(0, 1, 2, 3)]


@pytest.mark.parametrize(("max_bytes", "most"), [(float("inf"), 6), (70.0, 6), (16.0, 3), (10.0, 2), (3.0, 0)])
def test_a_flush_leaves_out_frames_that_have_no_room_but_not_the_newest(max_bytes: float, most: int) -> None:
    outbound = OutboundMotion(PARAMETERS)
    acknowledge(outbound, run(outbound, frames(1)))
    before = outbound.frames_sent
    outbound.wait_for_flush(True)
    run(outbound, frames(7)[1:])
    outbound.flush(max_bytes)
    sent = motion_of(outbound)
    assert sum(len(o.body) for o in sent) <= max_bytes
    numbers = [n for o in sent for n in o.frame_numbers]
    assert len(numbers) <= most and (not numbers or numbers[-1] == 6)
    assert outbound.frames_sent - before == len(numbers)


def test_frames_far_apart_are_reduced_to_the_newest() -> None:
    """Every second of frames four ticks apart would be eight ticks apart, which no payload can say."""
    outbound = OutboundMotion(PARAMETERS)
    outbound.wait_for_flush(True)
    run(outbound, [4 * n * FRAME_S for n in range(3)])
    outbound._frame_bytes = 20.0
    outbound.flush(max_bytes=40.0)
    assert all(o.frame_numbers == (8,) for o in motion_of(outbound))


def waiting(stamps: list[float], frame_bytes: float) -> OutboundMotion:
    """Return motion whose frames wait, each of an expected size."""
    outbound = OutboundMotion(PARAMETERS)
    outbound.wait_for_flush(True)
    assert [o for o in run(outbound, stamps) if o.frame_numbers] == []
    outbound._frame_bytes = frame_bytes
    return outbound


@pytest.mark.parametrize(
    ("step", "count", "max_bytes", "numbers"),
    [
        (1, 7, 701.1, (0, 1, 2, 3, 4, 5, 6)),
        (1, 7, 700.9, (0, 2, 4, 6)),
        (1, 7, 401.1, (0, 2, 4, 6)),
        (1, 7, 400.9, (2, 6)),
        (1, 7, 201.1, (2, 6)),
        (1, 7, 200.9, ()),
        (2, 4, 401.1, (0, 2, 4, 6)),
        (2, 4, 400.9, (2, 6)),
        (2, 4, 200.9, (6,)),
        (2, 4, 101.1, (6,)),
        (2, 4, 100.9, ()),
        (4, 3, 301.1, (0, 4, 8)),
        (4, 3, 300.9, (8,)),
        (1, 2, 201.1, (0, 1)),
        (1, 2, 200.9, (1,)),
        (1, 1, 101.1, (0,)),
        (1, 1, 100.9, ()),
    ],
)
def test_frames_that_wait_are_thinned_out_to_the_bytes_left(
    step: int, count: int, max_bytes: float, numbers: tuple[int, ...]
) -> None:
    outbound = waiting([number * step * FRAME_S for number in range(count)], 100.0 / SQUEEZE)
    outbound.flush(max_bytes)
    sent = outbound.drain()
    assert [o.frame_numbers for o in sent] == ([numbers] if numbers else [])
    assert outbound.frames_sent == len(numbers)
    for outgoing in sent:
        body = decode_body(outgoing.body)
        assert isinstance(body, MotionPayload)
        decoded = Decoder().decode(body.payload, numbers[0])
        assert tuple(one.frame_number for one in decoded) == numbers
    outbound.flush()
    assert outbound.drain() == []


def test_the_expected_size_of_a_frame_follows_the_payloads() -> None:
    outbound = waiting(frames(2), 100.0)
    outbound.flush()
    ((size,),) = [[len(o.body) - 1] for o in outbound.drain()]
    assert outbound._frame_bytes == pytest.approx(100 + (size / 2 - 100) / SMOOTHING)


def test_furrows_ride_with_the_motion_of_their_time_and_only_when_they_change() -> None:
    outbound = OutboundMotion(PARAMETERS)
    acknowledge(outbound, run(outbound, frames(1)))
    sent = []
    for stamp in frames(30, FRAME_S):
        outbound.send_frame(replace(frame(stamp), furrow=0.9), 100 + stamp)
        sent.append(kinds(bodies := outbound.drain()))
        for outgoing in bodies:
            outbound.on_sent(10 + len(sent), outgoing)
        outbound.on_acknowledged([10 + len(sent)])
    assert sent[0] == [FurrowMessage, MotionPayload] and FurrowMessage not in chain(*sent[1:])


def test_furrows_of_a_still_face_are_sent_with_its_motion() -> None:
    outbound = OutboundMotion(PARAMETERS)
    acknowledge(outbound, run(outbound, [0.0], move=0))
    found = []
    for stamp in frames(60, FRAME_S):
        outbound.send_frame(replace(frame(stamp, 0), furrow=0.9), 100 + stamp)
        found += [(kind, round(stamp, 1)) for kind in kinds(outbound.drain())]
    changes = [at for kind, at in found if kind is FurrowMessage]
    assert changes == [0.1, 1.1, 3.1], "repeated as nothing was acknowledged"
    assert [at for kind, at in found if kind is MotionPayload][:3] == [0.1, 0.6, 1.1]


@pytest.mark.parametrize(("room", "is_sent"), [(0, False), (FURROW_BYTES - 1, False), (FURROW_BYTES, True)])
def test_furrows_that_have_no_room_beside_the_motion_wait(room: int, is_sent: bool) -> None:
    ((size,),) = [[len(o.body) for o in run(OutboundMotion(PARAMETERS), [0.0]) if o.frame_numbers]]
    outbound = OutboundMotion(PARAMETERS)
    outbound.wait_for_flush(True)
    outbound.send_frame(replace(frame(0.0), furrow=0.9), 100.0)
    outbound.drain()
    outbound._frame_bytes = 1.0
    outbound.flush(size + room)
    assert kinds(outbound.drain()) == ([FurrowMessage] if is_sent else []) + [MotionPayload]
