"""Fit the codec's statistics: how far from its prediction a value lies in which context, and the tables of each scale.

Strategy. Differences from a prediction have a sharp peak and long tails at every scale; a mixture of two logistic
distributions of one centre follows that well. The logarithm of its scale is a weighted sum of the context's features:
the weights that make the observed differences likeliest are found by gradient ascent, for each value and each age of
the reference. The tables start from the mixture and move to what was counted as far as there was much to count.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import expit

from conf.protocol.codec.model import WEIGHT_ONE
from conf.protocol.codec.range_coder import TOTAL
from conf.protocol.codec.symbol_coder import ESCAPE, MAX_TABLE_MAGNITUDE, SCALES_PER_OCTAVE
from conf.protocol.codec.syntax import LOG_ONE

MIXTURE = ((0.65, 0.7), (0.35, 1.7))  # share of each logistic and its scale, relative
UNIT_SCALE = 16  # the scale index at which a logistic's scale is one step
SCALES = 21  # indices 0 to 20: from 1/16 of a step to two steps
PRIOR_COUNT = 300.0  # observations that the mixture counts as when a table is made
PULL = 2e-3  # keeps weights small where there is little to learn from
FLOOR = 1e-9

Floats = NDArray[np.float64]


def fit_weights(features: NDArray[np.int64], differences: NDArray[np.int64], /) -> NDArray[np.int16]:
    """Return the context weights (F,) that make the differences likeliest.

    features : (M, F), the first column constant
    differences : (M,) whole steps
    """
    inputs = features / LOG_ONE
    octaves = np.log(2) / SCALES_PER_OCTAVE * LOG_ONE

    def loss(weights: Floats) -> tuple[float, Floats]:
        index = inputs @ weights * LOG_ONE
        log_scale = np.clip((index - UNIT_SCALE) * np.log(2) / SCALES_PER_OCTAVE, -4, 8)
        chance, slope = _chance(differences, log_scale)
        gradient = inputs.T @ (-slope / chance) * octaves / len(differences)
        pull = PULL * np.concatenate([[0.0], weights[1:] * LOG_ONE / SCALES_PER_OCTAVE])
        penalty = float(pull[1:] @ weights[1:]) * LOG_ONE / SCALES_PER_OCTAVE
        return float(-np.log(chance).mean()) + penalty, gradient + 2 * pull * LOG_ONE / SCALES_PER_OCTAVE

    start = np.zeros(features.shape[1])
    spread = max(float(np.abs(differences).mean()), 0.05)
    start[0] = (UNIT_SCALE + SCALES_PER_OCTAVE * np.log2(0.6 * spread + 0.05)) / LOG_ONE
    found = minimize(loss, start, jac=True, method="L-BFGS-B", options={"maxiter": 60}).x
    limit = np.iinfo(np.int16).max
    return np.clip(np.rint(found * WEIGHT_ONE), -limit, limit).astype(np.int16)


def predict_scales(weights: NDArray[np.int16], features: NDArray[np.int64], /) -> NDArray[np.int64]:
    """Return the scale index (M,) that the codec computes from features (M, F)."""
    return np.asarray(features @ weights.astype(np.int64) // WEIGHT_ONE)


def fit_tables(scales: NDArray[np.int64], differences: NDArray[np.int64], /) -> NDArray[np.uint16]:
    """Return frequencies (SCALES, 2 REACH + 2) that sum to TOTAL for each scale.

    scales, differences : (M,) what was observed at which scale index
    """
    numbers = np.arange(-MAX_TABLE_MAGNITUDE, MAX_TABLE_MAGNITUDE + 1)
    tables = np.empty((SCALES, ESCAPE + 1), dtype=np.uint16)
    for scale in range(SCALES):
        log_scale = np.full(len(numbers), (scale - UNIT_SCALE) * np.log(2) / SCALES_PER_OCTAVE)
        shape = np.append(_chance(numbers, log_scale)[0], 0.0)
        shape[ESCAPE] = max(1.0 - float(shape.sum()), 1e-5)
        seen = differences[scales == scale]
        counts = np.bincount(
            np.where(np.abs(seen) <= MAX_TABLE_MAGNITUDE, seen + MAX_TABLE_MAGNITUDE, ESCAPE), minlength=ESCAPE + 1
        ).astype(float)
        counts[:ESCAPE] = (counts[:ESCAPE] + counts[:ESCAPE][::-1]) / 2  # neither side is the likelier
        tables[scale] = _whole(shape * PRIOR_COUNT + counts)
    return tables


def _chance(differences: NDArray[np.int64], log_scale: Floats) -> tuple[Floats, Floats]:
    """Return the probability of each difference and its derivative by log scale."""
    chance = np.full(len(differences), FLOOR)
    slope = np.zeros(len(differences))
    for share, width in MIXTURE:
        scale = np.exp(log_scale) * width
        above, below = (differences + 0.5) / scale, (differences - 0.5) / scale
        upper, lower = expit(above), expit(below)
        chance += share * (upper - lower)
        slope += share * (lower * (1 - lower) * below - upper * (1 - upper) * above)
    return chance, slope


def _whole(weights: Floats) -> NDArray[np.uint16]:
    """Return positive whole numbers in these proportions that sum to TOTAL."""
    numbers = 1 + np.floor((TOTAL - len(weights)) * weights / weights.sum())
    numbers[np.argmax(weights)] += TOTAL - numbers.sum()
    return np.asarray(numbers, dtype=np.uint16)
