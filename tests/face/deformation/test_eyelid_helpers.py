import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_COUNT, INDEX, UPPER_LID
from conf.face.deformation.eyelid_helpers import (
    MIXTURES,
    OWNERS,
    fold_margins,
    measured_margins,
    parabolic_margins,
    with_margins,
)
from conf.face.deformation.kernels import KERNELS
from conf.face.deformation.rbf import build_operator
from conf.face.deformation.regions import split_regions
from conf.face.mesh.depth_profiles import Shells
from conf.face.mesh.surface_graph import Surface
from tests.support.sheet_face import SheetFace


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


def eyes_of_height(face: SheetFace, height: float) -> Shells:
    """Return the sheet cut open between the corners of its eyes, a wall behind: gaps as high everywhere."""
    mesh = face.mesh
    middles = mesh.vertices[mesh.triangles].mean(axis=1)
    lids = face.points[[INDEX["eyelid_upper_l"], INDEX["eyelid_lower_l"]], 1]
    corners = face.points[[INDEX["eye_inner_corner_l"], INDEX["eye_outer_corner_l"]], 0]
    inside = (np.abs(middles[:, 1] - lids.mean()) < height / 2) & (np.abs(middles[:, 0]) > corners.min())
    inside &= np.abs(middles[:, 0]) < corners.max()
    wall = np.array([[-20.0, -20, 0], [20, -20, 0], [20, 20, 0], [-20, 20, 0]])
    count = len(mesh.vertices)
    triangles = np.concatenate(
        [mesh.triangles[~inside], [[count, count + 1, count + 2], [count, count + 2, count + 3]]]
    )
    shells = np.zeros(len(triangles), np.int32)
    shells[-2:] = 1
    return Shells(np.concatenate([mesh.vertices, wall]), triangles.astype(np.int32), shells)


def test_edges_that_are_seen_count_more_than_the_parabola(face: SheetFace) -> None:
    """The opening is a box: the lids are as far apart beside the middle as in it, and must travel as far."""
    gap = face.points[INDEX["eyelid_upper_l"], 1] - face.points[INDEX["eyelid_lower_l"], 1]
    margins = measured_margins(face.points, eyes_of_height(face, gap))
    shares = np.array([margins.mixtures[row, owner] for row, owner in enumerate(OWNERS)])
    assert (shares > 0.8).all()
    assert margins.mixtures.sum(axis=1) == pytest.approx(1)
    gaps = margins.places[:8, 1] - margins.places[8:, 1]  # of the parabola: 0.44 of the gap near the corners
    assert (gaps > 0.8 * gap).all()


def test_where_no_edges_are_seen_the_parabola_stays(face: SheetFace) -> None:
    shells = Shells(face.mesh.vertices, face.mesh.triangles, np.zeros(len(face.mesh.triangles), np.int32))
    measured, usual = measured_margins(face.points, shells), parabolic_margins(face.points)
    assert measured.places.tolist() == usual.places.tolist()
    assert measured.mixtures.tolist() == usual.mixtures.tolist()
