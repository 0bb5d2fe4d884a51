import numpy as np

from conf.animator.gui.influence_colours import UNAFFECTED, point_colours, region_colours
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel


def test_regions_are_coloured_where_something_moves(head: FaceModel) -> None:
    colours = region_colours(head.operator)
    assert colours.shape == (len(head.neutral), 3) and colours.min() >= 0 and colours.max() <= 1
    crown = head.neutral[:, 1].argmax()
    np.testing.assert_allclose(colours[crown], np.array(UNAFFECTED) / 255, atol=0.12)
    at = [np.linalg.norm(head.neutral - head.control_points[CONTROL_POINT_INDEX[name]], axis=1).argmin()
          for name in ("outer_lip_upper_mid", "outer_lip_lower_mid", "brow_top_l")]  # fmt: skip
    upper, lower, brow = colours[at]
    assert min(np.abs(upper - lower).max(), np.abs(upper - brow).max(), np.abs(lower - brow).max()) > 0.15


def test_one_points_influence_is_hottest_at_the_point(head: FaceModel) -> None:
    point = CONTROL_POINT_INDEX["brow_top_l"]
    heat = point_colours(head.operator, point)[:, 0]
    hottest = head.neutral[heat.argmax()]
    assert np.linalg.norm(hottest - head.control_points[point]) < 1.5
