"""Reports say what came; the round trip follows from them; decoding survives any bytes."""

from dataclasses import replace

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.feedback import (
    MAX_MILLISECONDS,
    MAX_REPORT_BYTES,
    ReceptionStats,
    Report,
    RoundTripEstimator,
    decode_report,
    encode_report,
)

CALM = Report(highest=1000, missing=0, lost=0, jitter_ms=7, ack_delay_ms=20)


@given(st.permutations(range(40)), st.integers(1, 40))
def test_a_report_says_exactly_what_has_come(order: list[int], count: int) -> None:
    reception, came = ReceptionStats(), set(order[:count])
    for counter in order[:count]:
        reception.add(counter, 0.0)
    report = reception.report(0.0)
    assert report is not None
    assert report.highest == max(came)
    assert set(report.acknowledged()) == came
    assert report.lost == max(came) + 1 - len(came)
    assert decode_report(encode_report(report)) == report


def test_long_ago_is_not_acknowledged() -> None:
    reception = ReceptionStats()
    for counter in range(200):
        reception.add(counter, 0.0)
    report = reception.report(0.0)
    assert report is not None and report.missing == 0
    assert report.acknowledged() == list(range(199, 135, -1))
    assert not report.received(135) and not report.received(200)


def test_reports_come_twice_a_second_once_there_is_something_to_say() -> None:
    reception = ReceptionStats()
    assert reception.report(0.0) is None
    reception.add(0, 0.2)
    times = [t / 10 for t in range(31) if reception.report(t / 10) is not None]
    assert times == pytest.approx([0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0])


def test_hold_and_jitter_are_in_milliseconds_and_bounded() -> None:
    reception = ReceptionStats()
    reception.add(0, 10.0, timestamp=0.0)
    reception.add(1, 10.5, timestamp=0.1)
    report = reception.report(10.53)
    assert report is not None
    assert (report.jitter_ms, report.ack_delay_ms) == (25, 30)
    late = reception.report(1000.0)
    assert late is not None and late.ack_delay_ms == MAX_MILLISECONDS


def test_a_calm_report_is_small() -> None:
    assert encode_report(CALM).hex() == "95cd03e800000714"
    worst = Report(0xFFFFFFFF, (1 << 63) - 1, 0xFFFFFFFE, MAX_MILLISECONDS, MAX_MILLISECONDS)
    assert len(encode_report(worst)) <= MAX_REPORT_BYTES
    assert decode_report(encode_report(worst)) == worst


@given(st.binary(max_size=40))
def test_any_bytes_are_a_report_or_a_protocol_error(data: bytes) -> None:
    try:
        report = decode_report(data)
    except ProtocolError:
        return
    assert decode_report(encode_report(report)) == report


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([1, 0, 0, 0], "not an array of five"),
        ([1, 0, 0, 0, 0, 0], "not msgpack"),
        ({}, "not an array of five"),
        ([1, 0, 0, 0, -1], "no small integer"),
        ([1, 0, 0, 0, True], "no small integer"),
        ([1, 0, 0, 0, 0.5], "no small integer"),
        ([1 << 32, 0, 0, 0, 0], "no small integer"),
        ([1, 0, 0, 1 << 16, 0], "no small integer"),
        ([1, 0, 2, 0, 0], "misses what was never sent"),
        ([1, 2, 0, 0, 0], "misses what was never sent"),
        ([1, 0, 0, 0, b"x" * 40], "too long"),
    ],
)
def test_what_is_wrong_with_a_report(value: object, message: str) -> None:
    with pytest.raises(ProtocolError, match=message):
        decode_report(msgpack.packb(value))


@given(st.floats(0, 5), st.integers(0, 3000), st.floats(0, 1e6))
def test_the_round_trip_is_what_it_is_whatever_the_hold(way: float, hold_ms: int, start: float) -> None:
    trip = RoundTripEstimator()
    trip.sent(5, start)
    trip.on_report(replace(CALM, highest=5, ack_delay_ms=hold_ms), start + way + hold_ms / 1000)
    assert trip.smoothed_s == pytest.approx(way, abs=1e-6)
    assert trip.min_rtt_s == pytest.approx(way, abs=1e-6)


def test_a_report_of_what_was_not_sent_or_already_echoed_gives_no_sample() -> None:
    trip = RoundTripEstimator()
    trip.on_report(CALM, 1.0)
    assert trip.smoothed_s is None and trip.min_rtt_s is None and trip.queueing_s == 0
    trip.sent(1000, 1.0)
    trip.on_report(CALM, 1.12)
    trip.on_report(CALM, 9.0)
    assert trip.smoothed_s == pytest.approx(0.1)


def test_memory_is_bounded_and_the_floor_forgets() -> None:
    trip = RoundTripEstimator()
    for counter in range(5000):
        now = counter / 10
        trip.sent(counter, now)
        if counter % 5 == 0:
            way = 0.1 if counter < 2000 else 0.4
            trip.on_report(replace(CALM, highest=counter, ack_delay_ms=0), now + way)
    assert len(trip._sent) <= RoundTripEstimator.REMEMBERED
    assert trip.min_rtt_s == pytest.approx(0.4)
    assert len(trip._samples) <= 62


def test_queueing_is_what_the_newest_samples_have_over_the_shortest() -> None:
    trip = RoundTripEstimator()
    for counter, way in enumerate([0.1] * 10 + [0.5] * 5):
        trip.sent(counter, float(counter))
        trip.on_report(replace(CALM, highest=counter, ack_delay_ms=0), counter + way)
    assert trip.queueing_s == pytest.approx(0.4)
