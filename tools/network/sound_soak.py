"""Figures over time of the sound of a long call, from the log of tools/bench/sound_probe.py."""

from itertools import pairwise
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

Lines = list[dict[str, Any]]

LAGS_S = np.arange(-0.4, 0.401, 0.005)
STEP_S = 0.01  # at which lips and voice are compared
ENERGY_BLOCKS = 4  # of 10 ms: the window of the speech energy is a frame of a clip
FLOOR_DBFS = -50.0  # below it there is silence
NO_FIGURE = float("nan")


def sound_row(received: Lines, begin: float, end: float) -> dict[str, float]:
    """Return the figures of the sound between two times.

    underruns : how often the loudspeaker had nothing to play; callback_gap_ms : the longest time between two of its
    callbacks; skew_ms : by how much the stream time heard was ahead of the stream time shown, median while somebody
    talked; lip_lag_ms : by how much the lips drawn were later than the sound heard, from their correlation
    """
    before = [line for line in received if line["at"] < begin]
    lines = [line for line in received if begin <= line["at"] <= end]
    if not lines or "heard" not in lines[0]:
        return {}
    first = before[-1] if before else lines[0]
    heard, images = (_flat(lines, name) for name in ("heard", "pictures"))
    return {
        "output_ms": round(median(line["output_ms"] for line in lines), 1),
        "underruns": lines[-1]["underruns"] - first["underruns"],
        "missing_ms": round(lines[-1]["missing_ms"] - first["missing_ms"], 1),
        "callback_gap_ms": round(max(line["callback_gap_ms"] for line in lines), 1),
        "concealed_ms": round(sum(line["concealed_ms"] for line in lines)),
        "skew_ms": round(1000 * skew(heard, images), 1),
        "lip_lag_ms": round(1000 * lip_lag(heard, _flat(lines, "openings")), 1),
    }


def _flat(lines: Lines, name: str) -> list[list[float]]:
    return [entry for line in lines for entry in line[name]]


def skew(heard: list[list[float]], images: list[list[float]]) -> float:
    """Return by how much the voice was ahead of the lips on the stream's clock, s: the median over all images.

    heard : (time, stream time heard then, whether somebody talked, level); images : (time, stream time shown, ...)
    """
    if len(heard) < 2 or not images:
        return NO_FIGURE
    times, positions, talks = (np.array(column, np.float64) for column in list(zip(*heard, strict=True))[:3])
    at, shown = (np.array(column, np.float64) for column in list(zip(*images, strict=True))[:2])
    talking = np.interp(at, times, talks) == 1.0
    differences = (np.interp(at, times, positions) - shown)[talking & (at > times[0]) & (at < times[-1])]
    return float(np.median(differences)) if len(differences) else NO_FIGURE


def lip_lag(heard: list[list[float]], openings: list[list[float]]) -> float:
    """Return the lag of lip opening behind speech energy at which the two correlate best, s.

    One clip alone has a lag of its own; a clip that is looped has the same in every minute, so that drift shows.
    heard : (end of 10 ms, ..., level in dBFS); openings : (time, lip opening)
    """
    if len(heard) < 2 or len(openings) < 2:
        return NO_FIGURE
    ends, levels = np.array([entry[0] for entry in heard]), np.array([entry[3] for entry in heard])
    at, opening = np.array(openings, np.float64).T
    grid = np.arange(max(at[0], ends[0]) - LAGS_S[0], min(at[-1], ends[-1]) - LAGS_S[-1], STEP_S)
    if len(grid) < 2:
        return NO_FIGURE
    powers = 10 ** (np.maximum(levels, FLOOR_DBFS) / 10)
    smooth = np.convolve(powers, np.ones(ENERGY_BLOCKS) / ENERGY_BLOCKS, mode="same")
    middles = ends - (STEP_S if ENERGY_BLOCKS % 2 == 0 else STEP_S / 2)
    energy = np.log(np.interp(grid, middles, smooth))
    return float(LAGS_S[np.argmax([_correlation(np.interp(grid + lag, at, opening), energy) for lag in LAGS_S])])


def _correlation(a: NDArray[np.floating], b: NDArray[np.floating]) -> float:
    a, b = a - a.mean(), b - b.mean()
    return float(a @ b / max(float(np.linalg.norm(a) * np.linalg.norm(b)), 1e-12))


def sound_totals(rows: list[dict[str, float]]) -> dict[str, float]:
    """Return totals of rows of `sound_row`: sums, maxima, and how far skew and lag have drifted."""
    rows = [row for row in rows if "skew_ms" in row]
    if not rows:
        return {}
    totals: dict[str, float] = {name: sum(row[name] for row in rows) for name in ("underruns", "concealed_ms")}
    totals["callback_gap_ms"] = max(row["callback_gap_ms"] for row in rows)
    for name in ("skew_ms", "lip_lag_ms"):
        values = [row[name] for row in rows if not np.isnan(row[name])]
        if values:
            totals[f"{name[:-3]}_range_ms"] = round(max(values) - min(values), 1)
            totals[f"{name[:-3]}_step_ms"] = round(max([abs(b - a) for a, b in pairwise(values)] or [0.0]), 1)
    return totals
