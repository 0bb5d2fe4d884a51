"""The shipped tables: small, complete, in whole numbers, with a row for every age."""

from importlib import resources

import numpy as np
import pytest

from conf.protocol.codec.model import FILE, CodecModel, load_models
from conf.protocol.codec.profiles import PROFILES
from conf.protocol.codec.range_coder import TOTAL
from conf.protocol.codec.reference_frames import MAX_AGE
from conf.protocol.codec.syntax import FEATURE_COUNT, LOG_ONE

MODELS = load_models()


def test_the_file_is_small() -> None:
    assert len(resources.files("conf.assets").joinpath(FILE).read_bytes()) < 200_000


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_every_age_has_rows_of_weights_and_every_value_a_weight_for_each_feature(model: CodecModel) -> None:
    assert len(model.rows) == len(model.second_reference_rows) == MAX_AGE + 1
    assert model.rows[0] == model.second_reference_rows[0] == 0
    assert max(model.second_reference_rows) == len(model.weights) - 1
    weights = np.array(model.weights)
    assert weights.shape[1:] == (len(model.default_reference.values), FEATURE_COUNT)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_what_steers_the_coder_is_whole_numbers(model: CodecModel) -> None:
    steering = [*model.default_reference.values, model.scale_coupling, *np.array(model.weights, dtype=object).ravel()]
    assert all(type(number) is int for number in steering)
    assert all(table[-1] == TOTAL for table in model.tables.cumulative)


def test_an_older_reference_makes_wider_scales() -> None:
    model = MODELS["live"]
    features = (LOG_ONE, *[0] * (FEATURE_COUNT - 1))
    widths = [
        np.mean([model.scale(model.rows[age], value, features) for value in range(6, 12)]) for age in (1, 2, 4, 8)
    ]
    assert widths == sorted(widths)


def test_every_profile_has_a_model() -> None:
    assert {name: model.profile for name, model in MODELS.items()} == PROFILES
