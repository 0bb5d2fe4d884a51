import numpy as np

from conf.protocol.portrait.face_shape import load_face_model
from tools.train_portrait import CONTROLS, Poses, cost_of, learn


def track(seed: int) -> Poses:
    """Return faces that differ from the shipped average by width, height and a little noise."""
    rng = np.random.default_rng(seed)
    mean = load_face_model().mean
    size = rng.uniform(0.9, 1.1, 3)
    points = np.rint(mean * size + rng.normal(0, 1, (8, *mean.shape))).astype(np.int64)
    return Poses(points, points[:, :CONTROLS] + rng.integers(-2, 3, (8, CONTROLS, 3)))


def test_what_is_learned_makes_a_strangers_face_cheaper_than_a_byte_a_coordinate() -> None:
    model = learn([track(seed) for seed in range(6)])
    stranger = track(99)
    coordinates = stranger.points[0].size + stranger.neutral[0].size
    assert cost_of(model, stranger) < 0.6 * coordinates


def test_the_control_points_are_told_first_and_by_each_other() -> None:
    model = learn([track(seed) for seed in range(4)])
    assert set(model.order[:CONTROLS]) == set(range(CONTROLS))
    assert all(model.parents[i] < i for i in range(len(model.parents)))
