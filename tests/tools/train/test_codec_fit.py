"""Fitting the codec's statistics: known weights are recovered, and tables are complete."""

import numpy as np
import pytest

from conf.protocol.codec.range_coder import TOTAL
from conf.protocol.codec.reconstruction import Reconstruction
from conf.protocol.codec.reference_frames import LOG_SCALE
from conf.protocol.codec.symbol_coder import ESCAPE, MAX_TABLE_MAGNITUDE, Tables
from conf.protocol.codec.syntax import LOG_ONE
from tools.train.codec_fit import SCALES, fit_reconstruction, fit_tables, fit_weights, predict_scales


def test_the_scale_follows_the_feature_that_determines_it() -> None:
    random = np.random.default_rng(3)
    activity = random.integers(0, 64, size=4000)
    width = 0.4 * 2 ** (activity / LOG_ONE)
    differences = np.rint(random.logistic(size=4000) * width).astype(np.int64)
    features = np.stack([np.full(4000, LOG_ONE), activity, random.integers(0, 64, size=4000)], axis=1)
    weights = fit_weights(features, differences)
    scales = predict_scales(weights, features)
    assert np.corrcoef(scales, activity)[0, 1] > 0.98
    octaves = (scales[activity == 63].mean() - scales[activity == 0].mean()) / 4
    assert octaves == pytest.approx(63 / LOG_ONE, abs=0.4)


def test_tables_are_complete_without_observations() -> None:
    nothing = np.zeros(0, dtype=np.int64)
    frequencies = fit_tables(nothing, nothing)
    assert frequencies.shape == (SCALES, ESCAPE + 1)
    assert (frequencies.sum(axis=1, dtype=int) == TOTAL).all()
    Tables.from_frequencies(frequencies.tolist())


def test_tables_follow_the_counts() -> None:
    observed = np.array([0] * 9000 + [1] * 500 + [-1] * 500 + [999])
    table = fit_tables(np.full(len(observed), 7), observed)[7]
    assert table[MAX_TABLE_MAGNITUDE] / TOTAL == pytest.approx(0.9, abs=0.02)
    assert table[MAX_TABLE_MAGNITUDE + 1] == pytest.approx(table[MAX_TABLE_MAGNITUDE - 1], abs=2)


def test_the_reconstruction_finds_the_motion_that_rounding_hid() -> None:
    rng = np.random.default_rng(4)
    exact = np.cumsum(rng.normal(0, 0.3, (3000, 3)), axis=0)
    exact[:, 2] = exact[:, 1] / 2  # moves with another one
    coded = np.rint(exact)
    values, earlier, errors = coded[2:], np.stack([coded[1:-1], coded[:-2]], axis=1), (exact - coded)[2:]
    coefficients = fit_reconstruction(values, earlier, errors)
    reconstruction = Reconstruction(coefficients[0], coefficients[1:].reshape(2, 3, 3))
    left = errors - [reconstruction.expected_error(v, list(e)) for v, e in zip(values, earlier, strict=True)]
    assert not coefficients[:, LOG_SCALE].any()
    assert np.mean(left[:, 1] ** 2) < 0.8 * np.mean(errors[:, 1] ** 2)
    assert np.mean(left[:, 2] ** 2) < 0.85 * np.mean(errors[:, 2] ** 2)
