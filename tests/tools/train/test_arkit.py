import numpy as np

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.retargeting.arkit_csv import SHAPES
from tools.train.arkit import MIRRORED, PAIRS, fit_map, predict, sculpted_mixtures


def test_a_map_gives_back_the_weights_it_was_learned_from() -> None:
    mixtures = sculpted_mixtures()
    scale = np.full(3 * CONTROL_POINT_COUNT, 100.0)
    predicted = predict(mixtures, fit_map([mixtures], mixtures, scale), scale)
    learned = [SHAPES.index(name) for name in ("jawOpen", "eyeBlinkLeft", "browInnerUp", "mouthSmileRight")]
    assert np.abs(predicted - mixtures.weights)[:, learned].mean() < 0.05
    for first, second in PAIRS:
        assert np.minimum(predicted[:, first], predicted[:, second]).max() < 1e-9


def test_a_mirrored_sample_has_the_weights_of_the_other_side() -> None:
    mixtures = sculpted_mixtures()
    mirrored = mixtures.mirrored()
    left, right = SHAPES.index("mouthSmileLeft"), SHAPES.index("mouthSmileRight")
    assert MIRRORED[left] == right and MIRRORED[SHAPES.index("jawOpen")] == SHAPES.index("jawOpen")
    np.testing.assert_array_equal(mirrored.weights[:, left], mixtures.weights[:, right])
    np.testing.assert_allclose(mirrored.mirrored().displacements, mixtures.displacements)
