import numpy as np

from conf.face.portrait.features import MOUTH
from conf.face.portrait.sprite import FeatureMap
from conf.face.portrait.warp import PortraitWarp
from tests.face.portrait.synthetic import face_shape


def test_a_patch_cut_from_the_photograph_lies_where_it_was_cut() -> None:
    warp = PortraitWarp(face_shape())
    sprite = FeatureMap(MOUTH, warp.flat, warp.fields)
    to_patch = lambda places: places * (0.1, -0.12) + (0.5, 0.2)  # noqa: E731
    placed = sprite.place(to_patch(warp.flat[list(MOUTH.points)]))
    seen = sprite.weights > 0
    np.testing.assert_allclose(placed[seen], to_patch(warp.flat[seen]), atol=5e-3)
