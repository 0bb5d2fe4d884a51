"""Reports in bytes, the round trip estimated from them, and decoding that survives any bytes."""

from dataclasses import replace

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.feedback import (
    MAX_MILLISECONDS,
    MAX_REPORT_BYTES,
    Report,
    RoundTripEstimator,
    decode_report,
    encode_report,
)

TYPICAL = Report(highest=1000, missing=0, lost=0, jitter_ms=7, ack_delay_ms=20)


def estimator(*round_trips: float) -> RoundTripEstimator:
    """Return an estimator with samples a second apart."""
    made = RoundTripEstimator()
    for counter, round_trip in enumerate(round_trips):
        made.on_sent(counter, float(counter))
        made.on_report(replace(TYPICAL, highest=counter, ack_delay_ms=0), counter + round_trip)
    return made


@pytest.mark.parametrize(
    ("highest", "missing", "acknowledged"),
    [
        (0, 0, [0]),
        (3, 0, [3, 2, 1, 0]),
        (3, 0b111, [3]),
        (3, 0b010, [3, 2, 0]),
        (100, 0, list(range(100, 36, -1))),  # 63 before the highest
        (64, 0, list(range(64, 0, -1))),
        (100, (1 << 63) - 1, [100]),
        (100, (1 << 62) - 1, [100, 37]),
        (100, 1 << 62, list(range(100, 37, -1))),
    ],
)
def test_a_report_confirms_the_highest_and_what_is_not_missing(
    highest: int, missing: int, acknowledged: list[int]
) -> None:
    assert Report(highest, missing, 0, 0, 0).acknowledged() == acknowledged


def test_reports_in_bytes() -> None:
    assert encode_report(TYPICAL).hex() == "cd03e800000714"
    largest = Report(0xFFFFFFFF, (1 << 63) - 1, 0xFFFFFFFE, MAX_MILLISECONDS, MAX_MILLISECONDS)
    assert len(encode_report(largest)) <= MAX_REPORT_BYTES
    assert decode_report(encode_report(largest)) == largest
    all_lost = Report(5, 0b11111, 5, 0, 0)
    assert decode_report(encode_report(all_lost)) == all_lost


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
        ([1, 0, 0, 0], "not five msgpack integers"),
        ([1, 0, 0, 0, 0, 0], "not five msgpack integers"),
        ([1, 0, 0, 0, {}], "no small integer"),
        ([1, 0, 0, 0, -1], "no small integer"),
        ([1, 0, 0, 0, True], "no small integer"),
        ([1, 0, 0, 0, 0.5], "no small integer"),
        ([1 << 32, 0, 0, 0, 0], "no small integer"),
        ([(1 << 32) - 1, 1 << 63, 0, 0, 0], "no small integer"),
        ([1, 0, 0, 1 << 16, 0], "no small integer"),
        ([1, 0, 0, 0, 1 << 16], "no small integer"),
        ([1, 0, 2, 0, 0], "never sent"),
        ([1, 2, 0, 0, 0], "never sent"),
        ([1, 0, 0, 0, b"x" * 40], "too long"),
        ([1, 0, 0, 0, b"x"], "not five msgpack integers"),
        ([1, 0, 0, 0, "x"], "not five msgpack integers"),
        ([1, 0, 0, 0, {1: 1}], "not five msgpack integers"),
        ([1, 0, 0, 0, msgpack.ExtType(1, b"x")], "not five msgpack integers"),
    ],
)
def test_bad_reports_are_explained(value: list[object], message: str) -> None:
    with pytest.raises(ProtocolError, match=message):
        decode_report(b"".join(map(msgpack.packb, value)))


@pytest.mark.slow
@given(st.floats(0, 5), st.integers(0, 3000), st.floats(0, 1e6))
def test_the_delay_of_the_report_is_no_part_of_the_round_trip(way: float, delay_ms: int, start: float) -> None:
    round_trip = RoundTripEstimator()
    round_trip.on_sent(5, start)
    round_trip.on_report(replace(TYPICAL, highest=5, ack_delay_ms=delay_ms), start + way + delay_ms / 1000)
    assert round_trip.smoothed_s == pytest.approx(way, abs=1e-6)
    assert round_trip.min_rtt_s == pytest.approx(way, abs=1e-6)


def test_a_report_of_32_bytes_is_not_too_long() -> None:
    data = encode_report(TYPICAL)
    with pytest.raises(ProtocolError, match="not five msgpack integers"):
        decode_report(data + bytes(MAX_REPORT_BYTES - len(data)))
    with pytest.raises(ProtocolError, match="too long"):
        decode_report(data + bytes(MAX_REPORT_BYTES - len(data) + 1))


def test_a_delay_longer_than_the_round_trip_gives_zero() -> None:
    round_trip = RoundTripEstimator()
    round_trip.on_sent(1000, 1.0)
    round_trip.on_report(TYPICAL, 1.01)
    assert round_trip.smoothed_s == 0.0


def test_a_report_of_an_unknown_or_known_counter_gives_no_sample() -> None:
    round_trip = RoundTripEstimator()
    round_trip.on_report(TYPICAL, 1.0)
    assert round_trip.smoothed_s is None and round_trip.min_rtt_s is None and round_trip.queueing_s == 0
    round_trip.on_sent(1000, 1.0)
    round_trip.on_report(TYPICAL, 1.12)
    round_trip.on_report(TYPICAL, 9.0)
    assert round_trip.smoothed_s == pytest.approx(0.1)


def test_the_round_trip_is_smoothed_by_an_eighth() -> None:
    assert estimator(0.1, 0.9).smoothed_s == pytest.approx(0.2)
    assert estimator(0.9, 0.1).smoothed_s == pytest.approx(0.8)


def test_memory_is_bounded_and_the_shortest_round_trip_is_of_the_last_half_minute() -> None:
    round_trip = RoundTripEstimator()
    for counter in range(5000):
        now = counter / 10
        round_trip.on_sent(counter, now)
        if counter % 5 == 0:
            way = 0.1 if counter < 2000 else 0.4
            round_trip.on_report(replace(TYPICAL, highest=counter, ack_delay_ms=0), now + way)
    assert len(round_trip._sent_at) == RoundTripEstimator.MAX_REMEMBERED
    assert round_trip.min_rtt_s == pytest.approx(0.4)
    assert len(round_trip._samples) <= 62
    assert estimator(0.1, *[0.4] * 30).min_rtt_s == pytest.approx(0.4)
    assert estimator(0.1, *[0.4] * 29).min_rtt_s == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("round_trips", "queueing_s"),
    [([0.5], 0.0), ([0.1, 0.5], 0.0), ([0.1, 0.5, 0.3], 0.2), ([0.1, 0.3, 0.5, 0.1], 0.0)],
)
def test_the_newest_queueing_takes_two_samples(round_trips: list[float], queueing_s: float) -> None:
    assert estimator(*round_trips).newest_queueing_s == pytest.approx(queueing_s)


@pytest.mark.parametrize(
    ("round_trips", "queueing_s"),
    [
        ([0.1], 0.0),
        ([0.1] * 10 + [0.5] * 5, 0.4),
        ([0.1] * 10 + [0.5] * 2, 0.0),
        ([0.1] * 10 + [0.5] * 3, 0.4),
        ([0.1, 0.2, 0.3, 0.4, 0.5, 0.6], 0.3),
    ],
)
def test_queueing_is_the_median_of_five_samples_minus_the_shortest(round_trips: list[float], queueing_s: float) -> None:
    assert estimator(*round_trips).queueing_s == pytest.approx(queueing_s)
