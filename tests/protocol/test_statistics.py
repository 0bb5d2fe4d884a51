from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.messages import (
    Bye,
    Composite,
    KeepAlive,
    MotionPayload,
    PortraitAck,
    PortraitChunk,
    Presence,
    RoundTripMessage,
    SingleBody,
    VoiceFormatMessage,
    VoicePayload,
    VoiceStateMessage,
)
from conf.protocol.statistics import (
    WINDOW_S,
    InterarrivalJitter,
    MediaBytes,
    MediaTraffic,
    RateWindow,
    TrafficSnapshot,
    count_media,
    merge_snapshots,
    raw_frame_bytes,
)
from conf.protocol.voice.formats import VoiceFormat, VoiceState
from conf.protocol.wire import encode_body
from tests.support.simulated_calls import PARAMETERS


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
    media_bytes=MediaBytes(200, 150, 50, 100),
    media_bytes_per_second=MediaBytes(300.0, 225.0, 75.0, 150.0),
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
        media_bytes=MediaBytes(400, 300, 100, 200),
        media_bytes_per_second=MediaBytes(600.0, 450.0, 150.0, 300.0),
    )
    assert merge_snapshots([ONE]) == ONE


def test_a_stream_without_frames_adds_its_bytes_and_nothing_merged_is_zero() -> None:
    silent = replace(ONE, frames_received=0, wire_bytes_per_frame=80.0)
    assert merge_snapshots([ONE, silent]).wire_bytes_per_frame == 58.0
    assert merge_snapshots([silent]).wire_bytes_per_frame == 80.0
    assert set(vars(merge_snapshots([])).values()) == {0, MediaBytes()}


FACE, VOICE, CHUNK = MotionPayload(5, b"m" * 20), VoicePayload(9, False, 0, b"v" * 30), PortraitChunk(b"p" * 40)
FORMAT = VoiceFormatMessage(0, VoiceFormat("opus", 9000, 60, 1, fixed_size=False))
STATE, KEEP = VoiceStateMessage(VoiceState.SILENT, 60), KeepAlive(1.0, Presence.NO_FACE)


@pytest.mark.parametrize(
    ("body", "medium"),
    [
        (FACE, "face"),
        (PARAMETERS, "face"),
        (VOICE, "voice"),
        (FORMAT, "voice"),
        (STATE, "voice"),
        (CHUNK, "portrait"),
        (KEEP, "overhead"),
        (RoundTripMessage(20), "overhead"),
        (Bye(), "overhead"),
        (PortraitAck(b"aa"), "overhead"),
    ],
)
def test_a_body_counts_for_what_it_carries_and_the_rest_of_its_datagram_is_overhead(
    body: SingleBody, medium: str
) -> None:
    data = encode_body(body)
    amounts = count_media(data, len(data) + 42)
    assert amounts.total == len(data) + 42
    if medium == "overhead":
        assert amounts == MediaBytes(overhead=len(data) + 42)
    else:
        assert amounts == MediaBytes(**{medium: len(data)}, overhead=42)


def test_each_body_of_a_composite_counts_for_its_kind_and_the_lengths_are_overhead() -> None:
    data = encode_body(Composite((KEEP, FORMAT, FACE, VOICE, CHUNK)))
    face, voice, chunk = (len(encode_body(body)) for body in (FACE, VOICE, CHUNK))
    voice += len(encode_body(FORMAT))
    lengths = 4
    overhead = lengths + len(encode_body(KEEP)) + 42
    assert count_media(data, len(data) + 42) == MediaBytes(face, voice, chunk, overhead)


@given(st.binary(max_size=60))
def test_whatever_the_bytes_each_is_counted_once(data: bytes) -> None:
    amounts = count_media(data, len(data) + 42)
    assert amounts.total == len(data) + 42 and amounts.overhead >= 42


def test_media_that_begin_later_have_rates_over_the_same_time() -> None:
    traffic = MediaTraffic()
    for second in range(4):
        traffic.add(MediaBytes(face=100, overhead=42), float(second))
    traffic.add(MediaBytes(voice=50, overhead=42), 4.0)
    assert traffic.rates(4.0) == MediaBytes(100.0, 12.5, 0.0, 52.5)
    assert traffic.total == MediaBytes(400, 50, 0, 210)
    assert traffic.rates(60.0) == MediaBytes()
