"""Fit the codec's statistics: the context weights that predict the size of differences, the tables of each scale, and
the coefficients with which the decoder estimates what rounding lost.

Strategy. Differences from a prediction have a sharp peak and long tails at every scale; a mixture of two logistic
distributions with the same centre fits them well. The logarithm of its scale is a weighted sum of the context's
features. The maximum-likelihood weights are found by gradient descent, for each value and each age of the reference.
The tables combine the mixture, as a prior, with the counted frequencies. The decoder's coefficients are found by ridge
regression.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import expit

from conf.protocol.codec.model import WEIGHT_ONE
from conf.protocol.codec.range_coder import TOTAL
from conf.protocol.codec.reconstruction import near
from conf.protocol.codec.reference_frames import LOG_SCALE
from conf.protocol.codec.symbol_coder import ESCAPE, MAX_TABLE_MAGNITUDE, SCALES_PER_OCTAVE
from conf.protocol.codec.syntax import LOG_ONE

MIXTURE = ((0.65, 0.7), (0.35, 1.7))  # weight and relative scale of each logistic
UNIT_SCALE = 16  # the scale index at which a logistic's scale is one step
SCALES = 21  # indices 0 to 20: from 1/16 of a step to two steps
PRIOR_COUNT = 300.0  # observations that the mixture counts as in a table
REGULARISATION = 2e-3  # of the weights, where there are few observations
MIN_PROBABILITY = 1e-9
# Steps squared: regularise what the decoder adds towards 0, for the value's own border and for the history of all.
PREVIOUS_PRIOR, HISTORY_PRIOR = 30.0, 100.0

Floats = NDArray[np.float64]


def fit_weights(features: NDArray[np.int64], differences: NDArray[np.int64], /) -> NDArray[np.int16]:
    """Return the maximum-likelihood context weights (F,).

    features : (M, F), the first column constant
    differences : (M,) whole steps
    """
    inputs = features / LOG_ONE
    octaves = np.log(2) / SCALES_PER_OCTAVE * LOG_ONE

    def loss(weights: Floats) -> tuple[float, Floats]:
        index = inputs @ weights * LOG_ONE
        log_scale = np.clip((index - UNIT_SCALE) * np.log(2) / SCALES_PER_OCTAVE, -4, 8)
        probability, slope = _probability(differences, log_scale)
        gradient = inputs.T @ (-slope / probability) * octaves / len(differences)
        ridge = REGULARISATION * np.concatenate([[0.0], weights[1:] * LOG_ONE / SCALES_PER_OCTAVE])
        penalty = float(ridge[1:] @ weights[1:]) * LOG_ONE / SCALES_PER_OCTAVE
        return float(-np.log(probability).mean()) + penalty, gradient + 2 * ridge * LOG_ONE / SCALES_PER_OCTAVE

    start = np.zeros(features.shape[1])
    magnitude = max(float(np.abs(differences).mean()), 0.05)
    start[0] = (UNIT_SCALE + SCALES_PER_OCTAVE * np.log2(0.6 * magnitude + 0.05)) / LOG_ONE
    weights = minimize(loss, start, jac=True, method="L-BFGS-B", options={"maxiter": 60}).x
    limit = np.iinfo(np.int16).max
    return np.clip(np.rint(weights * WEIGHT_ONE), -limit, limit).astype(np.int16)


def predict_scales(weights: NDArray[np.int16], features: NDArray[np.int64], /) -> NDArray[np.int64]:
    """Return the scale index (M,) that the codec computes from features (M, F)."""
    return np.asarray(features @ weights.astype(np.int64) // WEIGHT_ONE)


def fit_tables(scales: NDArray[np.int64], differences: NDArray[np.int64], /) -> NDArray[np.uint16]:
    """Return frequencies (SCALES, ESCAPE + 1) that sum to TOTAL for each scale.

    scales, differences : (M,) scale index and value of each observation
    """
    numbers = np.arange(-MAX_TABLE_MAGNITUDE, MAX_TABLE_MAGNITUDE + 1)
    tables = np.empty((SCALES, ESCAPE + 1), dtype=np.uint16)
    for scale in range(SCALES):
        log_scale = np.full(len(numbers), (scale - UNIT_SCALE) * np.log(2) / SCALES_PER_OCTAVE)
        shape = np.append(_probability(numbers, log_scale)[0], 0.0)
        shape[ESCAPE] = max(1.0 - float(shape.sum()), 1e-5)
        observed = differences[scales == scale]
        symbols = np.where(np.abs(observed) <= MAX_TABLE_MAGNITUDE, observed + MAX_TABLE_MAGNITUDE, ESCAPE)
        counts = np.bincount(symbols, minlength=ESCAPE + 1).astype(float)
        counts[:ESCAPE] = (counts[:ESCAPE] + counts[:ESCAPE][::-1]) / 2  # both signs are equally likely
        tables[scale] = _integer_frequencies(shape * PRIOR_COUNT + counts)
    return tables


def fit_reconstruction(values: Floats, earlier: Floats, errors: Floats, /) -> Floats:
    """Return the coefficients (1 + HISTORY * V, V) of each value's error that minimise the squared error.

    values, errors : (N, V) of coded frames, and the distances from there to the exact values, steps
    earlier : (N, HISTORY, V) the values of the frames before each
    The first row is that of the value's own distance to the previous frame, the others are those of the history.
    """
    distances = earlier - values[:, None]
    previous = near(distances[:, 0])
    history = np.clip(distances, -1, 1).reshape(len(values), -1)
    prior = np.diag([PREVIOUS_PRIOR] + [HISTORY_PRIOR] * history.shape[1])
    coefficients = np.zeros((len(prior), values.shape[1]))
    for value in range(LOG_SCALE + 1, values.shape[1]):  # the log scale stays: the face centre is measured in it
        inputs = np.column_stack([previous[:, value], history])
        coefficients[:, value] = np.linalg.solve(inputs.T @ inputs + prior, inputs.T @ errors[:, value])
    return coefficients


def _probability(differences: NDArray[np.int64], log_scale: Floats) -> tuple[Floats, Floats]:
    """Return the probability of each difference and its derivative by log scale."""
    probability = np.full(len(differences), MIN_PROBABILITY)
    slope = np.zeros(len(differences))
    for weight, width in MIXTURE:
        scale = np.exp(log_scale) * width
        above, below = (differences + 0.5) / scale, (differences - 0.5) / scale
        upper, lower = expit(above), expit(below)
        probability += weight * (upper - lower)
        slope += weight * (lower * (1 - lower) * below - upper * (1 - upper) * above)
    return probability, slope


def _integer_frequencies(weights: Floats) -> NDArray[np.uint16]:
    """Return positive integers in these proportions that sum to TOTAL."""
    frequencies = 1 + np.floor((TOTAL - len(weights)) * weights / weights.sum())
    frequencies[np.argmax(weights)] += TOTAL - frequencies.sum()
    return np.asarray(frequencies, dtype=np.uint16)
