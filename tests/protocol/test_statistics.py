import pytest

from conf.protocol.statistics import WINDOW_S, InterarrivalJitter, RateWindow, raw_frame_bytes


def test_the_rate_is_that_of_the_window() -> None:
    window = RateWindow()
    for i in range(1000):
        window.add(100, i * 0.1)
    amount, events = window.rates(99.9)
    assert amount == pytest.approx(1000, rel=0.03)
    assert events == pytest.approx(10, rel=0.03)
    assert window.total == 100_000
    assert window.rates(99.9 + WINDOW_S) == (0.0, 0.0)


def test_jitter_of_an_even_stream_is_nothing_and_of_a_swinging_one_its_swing() -> None:
    even, swinging = InterarrivalJitter(), InterarrivalJitter()
    for i in range(400):
        even.add(i / 15, 1000 + i / 15)
        swinging.add(i / 15, i / 15 + 0.02 * (i % 2))
    assert even.seconds == pytest.approx(0, abs=1e-9)
    assert swinging.seconds == pytest.approx(0.02, rel=1e-3)


def test_raw_pixels_of_the_thesis() -> None:
    assert raw_frame_bytes(320, 240) == 230_400
