import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_COUNT, INDEX, UPPER_LID
from conf.face.geodesics import Surface
from conf.face.kernels import KERNELS
from conf.face.lid_margins import MIXTURES, OWNERS, fold_margins, with_margins
from conf.face.rbf import build_operator
from conf.face.regions import split_regions
from tests.face.conftest import SheetFace


def test_helper_points_lie_between_the_corners_of_their_eye(face: SheetFace) -> None:
    helpers = MIXTURES @ face.points
    for helper, owner in zip(helpers, OWNERS, strict=True):
        name = next(name for name, index in INDEX.items() if index == owner)
        ends = face.points[[INDEX[f"eye_{end}_corner_{name[-1]}"] for end in ("inner", "outer")], 0]
        assert ends.min() < helper[0] < ends.max()


def test_helper_points_move_with_the_whole_face_and_with_its_turns(face: SheetFace) -> None:
    assert MIXTURES.sum(axis=1) == pytest.approx(1)


def test_a_field_leaves_out_the_helpers_of_what_it_leaves_out(face: SheetFace) -> None:
    surface = Surface(face.mesh.vertices, face.mesh.triangles)
    centres, regions = with_margins(face.points, split_regions(surface, face.points, anchors=np.empty((0, 3))))
    assert centres.shape == (CONTROL_POINT_COUNT + len(OWNERS), 3)
    for field in regions.fields:
        for i, owner in enumerate(OWNERS):
            assert (owner in field.left_out) == (CONTROL_POINT_COUNT + i in field.left_out)


def test_an_eye_shuts_over_its_whole_width(face: SheetFace) -> None:
    surface = Surface(face.mesh.vertices, face.mesh.triangles)
    regions = split_regions(surface, face.points, anchors=np.empty((0, 3)))
    closing = np.zeros((50, 1))
    closing[INDEX["eyelid_upper_l"]] = -0.7
    row = OWNERS.index(UPPER_LID[0])
    places = MIXTURES[row] @ face.points
    one_field = type(regions).whole(1)
    centres, fields = with_margins(face.points, one_field)
    folded = build_operator(places[None], centres, kernel=KERNELS["multiquadric"], epsilon=1.0, regions=fields)
    assert fold_margins(folded.matrix) @ closing == pytest.approx(-0.7 * MIXTURES[row, UPPER_LID[0]], abs=1e-3)
