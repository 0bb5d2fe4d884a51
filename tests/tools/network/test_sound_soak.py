"""The figures of tools/network/sound_soak.py, from logs of calls whose skew is known."""

import numpy as np
import pytest

from tools.network.sound_soak import lip_lag, skew, sound_row, sound_totals

START = 100.0
SILENT_DBFS, LOUD_DBFS = -60.0, -20.0


def _talks(stream_time: float) -> bool:
    """Whether somebody talks: words of changing length."""
    return np.sin(2 * stream_time) + np.sin(3.3 * stream_time) + np.sin(7.1 * stream_time) > 0.3


def _heard(seconds: float, *, ahead: float = 0.0, always: bool = True) -> list[list[float]]:
    times = START + np.arange(0, seconds, 0.01)
    return [
        [at, at - START + ahead, always or _talks(at - START), LOUD_DBFS if _talks(at - START) else SILENT_DBFS]
        for at in times.tolist()
    ]


def _images(seconds: float) -> list[list[float]]:
    return [[at, at - START, 0.0] for at in (START + np.arange(0, seconds, 1 / 15)).tolist()]


def _openings(seconds: float, lag: float) -> list[list[float]]:
    return [[at, float(_talks(at - START - lag))] for at in (START + np.arange(0, seconds, 1 / 15)).tolist()]


def test_skew_is_the_stream_time_heard_less_the_one_shown_at_the_same_time() -> None:
    assert skew(_heard(10, ahead=0.03), _images(10)) == pytest.approx(0.03)
    assert skew(_heard(10, ahead=-0.1), _images(10)) == pytest.approx(-0.1)


def test_skew_counts_only_while_somebody_talks() -> None:
    heard = _heard(10, ahead=0.03, always=False)
    silent = [[at, position + (0.0 if talks else 0.2), talks, level] for at, position, talks, level in heard]
    assert skew(silent, _images(10)) == pytest.approx(0.03)
    assert np.isnan(skew([], _images(10)))


@pytest.mark.parametrize("lag", [-0.1, 0.0, 0.06])
def test_lips_lag_behind_the_sound_by_what_was_put_in(lag: float) -> None:
    assert lip_lag(_heard(30), _openings(30, lag)) == pytest.approx(lag, abs=0.03)


def test_a_row_counts_from_the_line_before_it() -> None:
    def line(at: float, underruns: int, heard: list[list[float]]) -> dict[str, object]:
        figures = {"underruns": underruns, "missing_ms": 0.0, "callback_gap_ms": 21.0, "output_ms": 60.0}
        return {"at": at, **figures, "concealed_ms": 60.0, "heard": heard, "pictures": [], "openings": []}

    received = [line(START - 1, 2, []), line(START, 2, _heard(2)), line(START + 1, 5, [])]
    row = sound_row(received, START - 0.5, START + 1)
    assert (row["underruns"], row["concealed_ms"], row["output_ms"]) == (3, 120, 60.0)
    assert sound_row([{"at": START}], START - 1, START + 1) == {}


def test_totals_tell_how_far_the_skew_has_drifted() -> None:
    rows = [
        {"underruns": 1, "concealed_ms": 60, "callback_gap_ms": 30.0, "skew_ms": skew_ms, "lip_lag_ms": 80.0}
        for skew_ms in (10.0, 12.0, 7.0)
    ]
    totals = sound_totals([{"from_s": 0.0}, *rows])
    assert (totals["underruns"], totals["concealed_ms"]) == (3, 180)
    assert (totals["skew_range_ms"], totals["skew_step_ms"], totals["lip_lag_range_ms"]) == (5.0, 5.0, 0.0)
