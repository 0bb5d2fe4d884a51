import numpy as np
import pytest

from conf.face.portrait.patch_features import FEATURES
from conf.protocol.portrait.probability_model import MODEL_FILE, load_portrait_model
from tools.train.portrait import CONTROLS, Poses, cost_of, model_arrays, train
from tools.train.portrait_patches import PatchCounts


def track(seed: int) -> Poses:
    """Return faces that differ from the shipped mean by width, height and noise."""
    rng = np.random.default_rng(seed)
    model = load_portrait_model()
    mean = model.face.mean
    points = np.rint(mean * rng.uniform(0.9, 1.1, 3) + rng.normal(0, 1, (8, *mean.shape))).astype(np.int64)
    neutral = points[:, :CONTROLS] + rng.integers(-2, 3, (8, CONTROLS, 3))
    patches = [r.points.mean + rng.integers(-9, 10, (8, *r.points.mean.shape)) for r in model.regions]
    return Poses(points, neutral, patches, [rng.integers(-20, 21, (8, len(r.descriptor_scale))) for r in model.regions])


@pytest.mark.slow
def test_a_face_outside_the_training_data_costs_less_than_a_byte_a_coordinate() -> None:
    model = train([track(seed) for seed in range(6)], [PatchCounts()])
    other = track(99)
    coordinates = other.points[0].size + other.neutral[0].size
    assert cost_of(model, other) < 0.6 * coordinates


def test_control_points_come_first_and_every_region_is_trained() -> None:
    model = train([track(seed) for seed in range(4)], [])
    assert set(model.face.order[:CONTROLS]) == set(range(CONTROLS))
    assert len(model.regions) == len(FEATURES)
    for tree in (model.face, *(region.points for region in model.regions)):
        assert all(tree.parents[i] < i for i in range(len(tree.parents)))


def test_the_probability_of_empty_blocks_is_trained() -> None:
    full, empty = PatchCounts(), PatchCounts()
    for _ in range(20):
        full.count([np.full((3, 3, 64), 5.0)] * 3)
        empty.count([np.zeros((3, 3, 64))] * 3)
    assert (full.model().coded[:, 2] > 30_000).all() and (empty.model().coded[:, 0] < 3_000).all()
    assert full.model().last[0].argmax() == 63
    assert full.model().coefficient_scale.min() > empty.model().coefficient_scale.max()


def test_the_arrays_are_those_of_the_shipped_file() -> None:
    arrays = model_arrays(load_portrait_model())
    with MODEL_FILE.open("rb") as file, np.load(file) as shipped:
        assert set(arrays) == set(shipped.files)
        for name, array in arrays.items():
            assert array.dtype == shipped[name].dtype == np.int16
            np.testing.assert_array_equal(array, shipped[name])
