"""The trained file: small, complete, in integers, with a row of weights for every age."""

from dataclasses import replace
from importlib import resources
from operator import attrgetter

import numpy as np
import pytest

from conf.protocol.codec.model import FILE, CodecModel, build_models, load_models
from conf.protocol.codec.profiles import PROFILES
from conf.protocol.codec.range_coder import TOTAL
from conf.protocol.codec.reference_frames import MAX_AGE
from conf.protocol.codec.syntax import FEATURE_COUNT, LOG_ONE
from tests.protocol.independent_decoder import Frame, PayloadReader

MODELS = load_models()
READER = PayloadReader()


@pytest.fixture(scope="module", params=PROFILES)
def model(request: pytest.FixtureRequest) -> CodecModel:
    """Return the model of each profile, built from the file's arrays."""
    return build_models(READER.arrays)[request.param]


def test_the_file_is_small() -> None:
    assert len(resources.files("conf.assets").joinpath(FILE).read_bytes()) < 200_000


def test_each_age_has_the_row_of_wire_md(model: CodecModel) -> None:
    second = Frame([], staggered=False)
    assert model.rows == tuple(READER.row(age, None) for age in range(64))
    assert model.second_reference_rows == tuple(READER.row(age, second) for age in range(64))
    assert MAX_AGE == 63
    assert np.shape(model.weights) == (21, len(model.default_reference.values), FEATURE_COUNT)


def test_the_model_holds_the_arrays_of_its_profile(model: CodecModel) -> None:
    name, arrays = model.profile.tables, READER.arrays
    assert model.default_reference.values == tuple(arrays[f"{name}_standing"].tolist())
    assert model.weights == arrays[f"{name}_weights"].tolist()
    assert model.scale_coupling == int(arrays[f"{name}_growth"])
    assert model.points == 50
    assert np.diff(model.tables.cumulative, axis=1).tolist() == arrays[f"{name}_frequencies"].tolist()


def test_the_transform_is_scaled_by_the_step(model: CodecModel) -> None:
    arrays, step, transform = READER.arrays, model.profile.step, model.transform
    analysis, synthesis = (arrays[name].astype(float) for name in ("analysis", "synthesis"))
    components = np.arange(float(len(synthesis))) - 9
    np.testing.assert_allclose(components @ transform.inverse_matrix, step * (components @ synthesis))
    displacements = np.linspace(-80, 90, 150)
    np.testing.assert_allclose(displacements @ transform.forward_matrix, displacements @ analysis / step)
    np.testing.assert_allclose(transform.pose_steps, arrays["pose_unit"].astype(float) * step)


def test_synthesis_inverts_analysis(model: CodecModel) -> None:
    transform = model.transform
    unit = np.eye(len(transform.inverse_matrix))
    np.testing.assert_allclose(transform.inverse_matrix @ transform.forward_matrix, unit, atol=1e-5)


def test_the_other_arrays_of_the_transform_are_those_of_the_file(model: CodecModel) -> None:
    arrays, transform = READER.arrays, model.transform
    assert type(transform.typical_log_scale) is float
    assert transform.typical_log_scale == pytest.approx(float(arrays["usual_log_scale"]))
    stored = {
        "face_centre": "middle",
        "residual_steps": "correction",
        "coupling": "coupling",
        "stagger": "stagger",
        "reconstruction.previous": f"{model.profile.tables}_lean",
        "reconstruction.history": f"{model.profile.tables}_history",
    }
    for field, name in stored.items():
        array = attrgetter(field)(transform)
        assert array.dtype == np.float64
        np.testing.assert_array_equal(array, arrays[name])
    assert {transform.forward_matrix.dtype, transform.pose_steps.dtype} == {np.dtype(np.float64)}


def test_all_that_steers_the_coder_is_integers(model: CodecModel) -> None:
    steering = [*model.default_reference.values, model.scale_coupling, *np.array(model.weights, dtype=object).ravel()]
    assert all(type(number) is int for number in steering)
    assert all(table[-1] == TOTAL for table in model.tables.cumulative)


@pytest.mark.parametrize(
    ("weights", "features", "scale"),
    [
        ((256, 0), (16, 5), 16),
        ((128, 64), (17, 3), 9),
        ((-256, 0), (4, 0), 0),
        ((256, 0), (52, 0), 52),
        ((256, 9), (53, 0), 52),
    ],
)
def test_the_scale_is_a_clamped_weighted_sum(weights: tuple[int, ...], features: tuple[int, ...], scale: int) -> None:
    model = replace(MODELS["live"], weights=[[], [[0, 0], list(weights)]])
    assert model.scale(1, 1, features) == scale


def test_an_older_reference_gives_larger_scales() -> None:
    model = MODELS["live"]
    features = (LOG_ONE, *[0] * (FEATURE_COUNT - 1))
    scales = [
        np.mean([model.scale(model.rows[age], value, features) for value in range(6, 12)]) for age in (1, 2, 4, 8)
    ]
    assert scales == sorted(scales)


def test_every_profile_has_a_model() -> None:
    assert {name: model.profile for name, model in MODELS.items()} == PROFILES
    assert build_models(READER.arrays).keys() == MODELS.keys()
