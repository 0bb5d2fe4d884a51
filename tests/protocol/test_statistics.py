from dataclasses import replace

import pytest

from conf.protocol.statistics import (
    WINDOW_S,
    InterarrivalJitter,
    RateWindow,
    TrafficSnapshot,
    merge_snapshots,
    raw_frame_bytes,
)


def test_the_rate_is_that_of_the_window() -> None:
    window = RateWindow()
    for i in range(1000):
        window.add(100, i * 0.1)
    amount, events = window.rates(99.9)
    assert amount == pytest.approx(1000, rel=0.03)
    assert events == pytest.approx(10, rel=0.03)
    assert (window.total, window.count) == (100_000, 1000) and len(window._recent) <= 51
    assert window.rates(99.9 + WINDOW_S) == (0.0, 0.0)
    assert window.total == 100_000


def test_before_the_window_is_full_the_rate_is_that_since_the_start_but_at_least_a_second() -> None:
    window = RateWindow()
    assert window.rates(5.0) == (0.0, 0.0)
    window.add(30, 10.0)
    assert window.rates(10.0) == (30.0, 1.0)
    window.add(50, 12.0)
    assert window.rates(12.0) == (40.0, 1.0)
    assert window.rates(14.0) == (20.0, 0.5)
    assert window.rates(9.9 + WINDOW_S) == pytest.approx((80 / 4.9, 2 / 4.9))
    assert window.rates(10.0 + WINDOW_S) == (10.0, 0.2)


def test_jitter_of_an_even_stream_is_zero_and_of_an_alternating_one_its_difference() -> None:
    even, alternating = InterarrivalJitter(), InterarrivalJitter()
    for i in range(400):
        even.add(i / 15, 1000 + i / 15)
        alternating.add(i / 15, i / 15 + 0.02 * (i % 2))
    assert even.seconds == pytest.approx(0, abs=1e-9)
    assert alternating.seconds == pytest.approx(0.02, rel=1e-3)


def test_jitter_moves_a_sixteenth_towards_each_difference() -> None:
    jitter = InterarrivalJitter()
    jitter.add(0.0, 10.0)
    assert jitter.seconds == 0.0
    jitter.add(1.0, 11.16)
    assert jitter.seconds == pytest.approx(0.01)
    jitter.add(2.0, 12.0)
    assert jitter.seconds == pytest.approx(0.01 + 0.15 / 16)


def test_raw_pixels_of_the_thesis() -> None:
    assert raw_frame_bytes(320, 240) == 230_400


ONE = TrafficSnapshot(
    frames_received=10,
    frames_lost=1,
    frames_late=2,
    datagrams=8,
    rejected=3,
    fps=15.0,
    wire_bytes_per_frame=50.0,
    wire_kbps=6.0,
    raw_bytes_per_frame=1000,
    raw_kbps=120.0,
    ratio=20.0,
    jitter_ms=4.0,
    playout_delay_ms=30.0,
)


def test_merged_counts_and_rates_are_added_means_weighted_and_delays_the_longest() -> None:
    other = replace(ONE, frames_received=30, wire_bytes_per_frame=70.0, raw_bytes_per_frame=2000, jitter_ms=9.0)
    assert merge_snapshots([ONE, replace(other, playout_delay_ms=20.0)]) == TrafficSnapshot(
        frames_received=40,
        frames_lost=2,
        frames_late=4,
        datagrams=16,
        rejected=6,
        fps=30.0,
        wire_bytes_per_frame=(500 + 2100) / 40,
        wire_kbps=12.0,
        raw_bytes_per_frame=1750,
        raw_kbps=240.0,
        ratio=70_000 / 2600,
        jitter_ms=9.0,
        playout_delay_ms=30.0,
    )
    assert merge_snapshots([ONE]) == ONE


def test_a_stream_without_frames_adds_its_bytes_and_nothing_merged_is_zero() -> None:
    silent = replace(ONE, frames_received=0, wire_bytes_per_frame=80.0)
    assert merge_snapshots([ONE, silent]).wire_bytes_per_frame == 58.0
    assert merge_snapshots([silent]).wire_bytes_per_frame == 80.0
    assert set(vars(merge_snapshots([])).values()) == {0}
