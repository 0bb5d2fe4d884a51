"""The datagrams of a session counted, and the reports made of them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.feedback import MAX_MILLISECONDS, Report, decode_report, encode_report
from conf.protocol.reception_statistics import ReceptionStatistics


@pytest.mark.slow
@given(st.permutations(range(40)), st.integers(1, 40))
def test_a_report_confirms_exactly_what_was_received(order: list[int], count: int) -> None:
    reception, received = ReceptionStatistics(), set(order[:count])
    for counter in order[:count]:
        reception.add(counter, 0.0)
    report = reception.report(0.0)
    assert report is not None
    assert report.highest == max(received)
    assert set(report.acknowledged()) == received
    assert report.lost == reception.lost == max(received) + 1 - len(received)
    assert decode_report(encode_report(report)) == report


def test_a_report_reaches_back_64_counters() -> None:
    reception = ReceptionStatistics()
    for counter in range(200):
        reception.add(counter, 0.0)
    report = reception.report(0.0)
    assert report is not None and report.missing == 0
    assert report.acknowledged() == list(range(199, 135, -1))


def test_a_gap_of_63_is_reported_completely() -> None:
    reception = ReceptionStatistics()
    reception.add(0, 0.0)
    reception.add(64, 0.0)
    report = reception.report(0.0)
    assert report is not None and report.missing == (1 << 63) - 1 and report.lost == 63
    assert report.acknowledged() == [64]


def test_an_undecodable_datagram_is_neither_lost_nor_acknowledged() -> None:
    reception = ReceptionStatistics()
    reception.add(0, 1.0)
    reception.add(1, 2.0, timestamp=5.0, decodable=False)
    report = reception.report(2.0)
    assert report == Report(highest=0, missing=0, lost=0, jitter_ms=0, ack_delay_ms=1000)


def test_lost_never_exceeds_the_highest_acknowledged() -> None:
    reception = ReceptionStatistics()
    reception.add(2, 0.0)
    reception.add(9, 0.0, decodable=False)
    report = reception.report(0.0)
    assert report is not None and (report.highest, report.lost, reception.lost) == (2, 2, 8)


@pytest.mark.parametrize(("interval_s", "times"), [(0.5, [0.0, 0.5, 1.0, 1.5, 2.0]), (0.9, [0.0, 0.9, 1.8])])
def test_reports_are_due_at_intervals_if_something_new_called_for_one(interval_s: float, times: list[float]) -> None:
    reception = ReceptionStatistics()
    assert reception.report(0.0) is None and not reception.report_due(0.0)
    due = []
    for tick in range(31):
        now = tick / 10
        if tick <= 20:
            reception.add(tick, now)
        if reception.report_due(now, interval_s=interval_s):
            due.append(now)
            reception.on_reported(now)
    assert due[: len(times)] == pytest.approx(times) and len(due) <= len(times) + 1


def test_a_datagram_of_acknowledgements_counts_but_calls_for_no_report() -> None:
    reception = ReceptionStatistics()
    for counter in range(3):
        reception.add(counter, 0.0, calls_for_report=False)
    report = reception.report(0.0)
    assert not reception.report_due(9.0) and reception.quiet == 3
    assert report is not None and report.highest == 2
    reception.add(3, 9.0)
    assert reception.report_due(9.0)
    reception.on_reported(9.0)
    assert not reception.report_due(99.0) and reception.quiet == 0


def test_a_datagram_that_could_not_be_used_calls_for_a_report_of_those_that_could() -> None:
    reception = ReceptionStatistics()
    reception.add(0, 0.0, decodable=False)
    assert not reception.report_due(0.0)
    reception.add(1, 0.0, calls_for_report=False)
    assert reception.report_due(0.0)


def test_delay_and_jitter_are_in_milliseconds_and_bounded() -> None:
    reception = ReceptionStatistics()
    reception.add(0, 10.0, timestamp=0.0)
    reception.add(1, 10.5, timestamp=0.1)
    report = reception.report(10.53)
    assert report is not None
    assert (report.jitter_ms, report.ack_delay_ms) == (25, 30)
    late = reception.report(1000.0)
    assert late is not None and late.ack_delay_ms == MAX_MILLISECONDS


def test_the_delay_is_that_of_the_highest_counter() -> None:
    reception = ReceptionStatistics()
    reception.add(5, 1.0)
    reception.add(4, 1.4)
    report = reception.report(1.5)
    assert report is not None and report.ack_delay_ms == 500
