"""A level is sent when it changes and until it has arrived, and costs nothing otherwise."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.messages import FurrowMessage
from conf.protocol.motion.furrow_announcer import FURROW_BYTES, HYSTERESIS, MIN_INTERVAL_S, REPEAT_S, FurrowAnnouncer
from conf.protocol.outgoing import OutgoingBody
from conf.protocol.wire import MAX_FURROW_LEVEL, decode_body

FRAME_S = 1 / 15


def run(announcer: FurrowAnnouncer, values: list[float], begin: float = 0.0) -> list[tuple[int, float, OutgoingBody]]:
    """Return level, time and body of each announcement; the frames follow each other at 15 a second."""
    found = []
    for number, value in enumerate(values):
        timestamp = begin + number * FRAME_S
        if announcer.is_due(value, timestamp):
            outgoing = announcer.body(value, timestamp)
            message = decode_body(outgoing.body)
            assert isinstance(message, FurrowMessage) and outgoing.furrow == message
            assert len(outgoing.body) + 1 == FURROW_BYTES
            found.append((message.level, timestamp, outgoing))
    return found


def test_a_brow_at_rest_costs_nothing() -> None:
    assert run(FurrowAnnouncer(), [0.0, (HYSTERESIS - 0.01) / MAX_FURROW_LEVEL] * 300) == []


def test_a_level_that_has_arrived_is_sent_once() -> None:
    announcer = FurrowAnnouncer()
    ((level, _, outgoing),) = run(announcer, [1.0])
    assert level == MAX_FURROW_LEVEL
    announcer.on_sent(7, outgoing)
    announcer.on_acknowledged([6])
    announcer.on_acknowledged([9, 8, 7])
    assert run(announcer, [1.0] * 900, FRAME_S) == []


def test_a_level_that_never_arrives_is_repeated_ever_more_rarely() -> None:
    sent = run(FurrowAnnouncer(), [0.5] * 15 * 120)
    assert [level for level, _, _ in sent] == [4] * 7
    assert [at for _, at, _ in sent] == pytest.approx([0, 1, 3, 7, 15, 31, 63], abs=2 * FRAME_S) and REPEAT_S == 1


def test_the_acknowledgement_of_an_earlier_level_is_none_of_this_one() -> None:
    announcer = FurrowAnnouncer()
    for counter, value in enumerate((0.4, 1.0, 0.4)):
        ((_, _, outgoing),) = run(announcer, [value], float(counter))
        announcer.on_sent(counter, outgoing)
    announcer.on_acknowledged([0, 1])
    assert len(run(announcer, [0.4] * 30, 2.0 + FRAME_S)) == 1


def test_a_frown_that_grows_and_fades_takes_few_bodies() -> None:
    frown = [min(1.0, 0.12 * i) for i in range(30)]
    sent = run(FurrowAnnouncer(), frown + frown[::-1] + [0.0] * 4)
    times = [at for _, at, _ in sent]
    assert sent[-1][0] == 0 and len(sent) <= 8
    assert all(b - a >= MIN_INTERVAL_S - 1e-9 for a, b in pairwise(times))


@given(st.lists(st.floats(-1, 2), min_size=1, max_size=60))
def test_what_the_receiver_holds_is_never_far_from_a_value_that_lasts(values: list[float]) -> None:
    announcer, held = FurrowAnnouncer(), 0
    lasting = [values[-1]] * 5
    for level, *_ in run(announcer, values + lasting):
        held = level
    assert abs(held - min(max(values[-1], 0.0), 1.0) * MAX_FURROW_LEVEL) <= HYSTERESIS
