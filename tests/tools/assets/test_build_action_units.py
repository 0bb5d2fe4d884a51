import numpy as np

from conf.face.animation.action_units import ACTION_UNIT_NAMES, load_action_units
from conf.face.symmetry import mirror_motion
from tools.assets.arkit_shapes import load_arkit_shapes
from tools.assets.build_action_units import RECIPES, blend

# FAPU units, about 0.67 mm at a brow: small changes of the head's blendshapes need no new files, another head does.
TOLERANCE = 15.0


def test_the_files_match_the_blendshapes() -> None:
    shapes, units = load_arkit_shapes(), load_action_units()
    assert set(RECIPES) == set(ACTION_UNIT_NAMES)
    for unit, recipe in RECIPES.items():
        np.testing.assert_allclose(units[unit], blend(shapes, recipe), atol=TOLERANCE, err_msg=str(unit))


def test_a_blend_has_both_sides_and_is_symmetric() -> None:
    shapes = load_arkit_shapes()
    smile = blend(shapes, {"mouthSmile": 0.5})
    np.testing.assert_array_equal(mirror_motion(smile), smile)
    by_hand = 0.5 * (shapes["mouthSmileLeft"] + shapes["mouthSmileRight"])
    np.testing.assert_allclose(smile, (by_hand + mirror_motion(by_hand)) / 2, atol=1e-3)
