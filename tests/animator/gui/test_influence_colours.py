import numpy as np
import pytest

from conf.animator.gui.influence_colours import UNAFFECTED, point_colours, region_colours
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel


@pytest.mark.slow
def test_regions_have_distinct_colours_and_unaffected_vertices_are_grey(head: FaceModel) -> None:
    colours = region_colours(head.operator)
    assert colours.shape == (len(head.neutral), 3) and colours.min() >= 0 and colours.max() <= 1
    crown = head.neutral[:, 1].argmax()
    np.testing.assert_allclose(colours[crown], np.array(UNAFFECTED) / 255, atol=0.12)
    names = ("outer_lip_upper_mid", "outer_lip_lower_mid", "brow_top_l")
    points = [head.control_points[CONTROL_POINT_INDEX[name]] for name in names]
    upper, lower, brow = (colours[np.linalg.norm(head.neutral - point, axis=1).argmin()] for point in points)
    assert min(np.abs(upper - lower).max(), np.abs(upper - brow).max(), np.abs(lower - brow).max()) > 0.15


def test_influence_of_one_point_is_highest_at_the_point(head: FaceModel) -> None:
    point = CONTROL_POINT_INDEX["brow_top_l"]
    red = point_colours(head.operator, point)[:, 0]
    assert np.linalg.norm(head.neutral[red.argmax()] - head.control_points[point]) < 1.5
