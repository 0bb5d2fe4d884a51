import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX, UPPER_LID, control_point_indices
from conf.face.deformation.eyelid_helpers import (
    HELPER_LIDS,
    PARABOLA_WEIGHTS,
    append_helpers,
    fold_helpers,
    helpers_on_edges,
    helpers_on_parabola,
    with_brow_helpers,
)
from conf.face.deformation.rbf import KERNELS, build_operator
from conf.face.deformation.regions import Regions, split_regions
from conf.face.mesh.depth_profiles import LabelledMesh
from conf.face.mesh.raycast import cast_front_rays
from conf.face.mesh.surface_graph import SurfaceGraph
from tests.support.sheet_face import SheetFace


def test_helper_points_lie_between_the_corners_of_their_eye(face: SheetFace) -> None:
    helpers = PARABOLA_WEIGHTS @ face.points
    for helper, lid in zip(helpers, HELPER_LIDS, strict=True):
        name = next(name for name, index in CONTROL_POINT_INDEX.items() if index == lid)
        ends = face.points[[CONTROL_POINT_INDEX[f"eye_{end}_corner_{name[-1]}"] for end in ("inner", "outer")], 0]
        assert ends.min() < helper[0] < ends.max()


def test_helper_weights_add_up_to_one(face: SheetFace) -> None:
    assert PARABOLA_WEIGHTS.sum(axis=1) == pytest.approx(1)


def test_a_field_excludes_the_helpers_of_excluded_lids(face: SheetFace) -> None:
    surface = SurfaceGraph(face.mesh.vertices, face.mesh.triangles)
    regions = split_regions(surface, face.points, anchors=np.empty((0, 3)))
    centres, regions = append_helpers(face.points, regions, helpers_on_parabola(face.points))
    assert centres.shape == (CONTROL_POINT_COUNT + len(HELPER_LIDS), 3)
    for field in regions.fields:
        for i, lid in enumerate(HELPER_LIDS):
            assert (lid in field.excluded) == (CONTROL_POINT_COUNT + i in field.excluded)


def test_helpers_close_an_eye_over_its_whole_width(face: SheetFace) -> None:
    closing = np.zeros((50, 1))
    closing[CONTROL_POINT_INDEX["eyelid_upper_l"]] = -0.7
    row = HELPER_LIDS.tolist().index(UPPER_LID[0])
    positions = PARABOLA_WEIGHTS[row] @ face.points
    helpers = helpers_on_parabola(face.points)
    centres, fields = append_helpers(face.points, Regions.unrestricted(1), helpers)
    folded = build_operator(positions[None], centres, kernel=KERNELS["multiquadric"], epsilon=1.0, regions=fields)
    assert fold_helpers(folded.matrix, helpers) @ closing == pytest.approx(
        -0.7 * PARABOLA_WEIGHTS[row, UPPER_LID[0]], abs=1e-3
    )


def eyes_of_height(face: SheetFace, height: float) -> LabelledMesh:
    """Return the sheet with a rectangular hole between the corners of each eye, and a wall behind it."""
    mesh = face.mesh
    centres = mesh.vertices[mesh.triangles].mean(axis=1)
    lids = face.points[[CONTROL_POINT_INDEX["eyelid_upper_l"], CONTROL_POINT_INDEX["eyelid_lower_l"]], 1]
    corners = face.points[[CONTROL_POINT_INDEX["eye_inner_corner_l"], CONTROL_POINT_INDEX["eye_outer_corner_l"]], 0]
    inside = (np.abs(centres[:, 1] - lids.mean()) < height / 2) & (np.abs(centres[:, 0]) > corners.min())
    inside &= np.abs(centres[:, 0]) < corners.max()
    wall = np.array([[-20.0, -20, 0], [20, -20, 0], [20, 20, 0], [-20, 20, 0]])
    count = len(mesh.vertices)
    triangles = np.concatenate(
        [mesh.triangles[~inside], [[count, count + 1, count + 2], [count, count + 2, count + 3]]]
    )
    labels = np.zeros(len(triangles), np.int32)
    labels[-2:] = 1
    return LabelledMesh(np.concatenate([mesh.vertices, wall]), triangles.astype(np.int32), labels)


def test_measured_edges_replace_the_parabola(face: SheetFace) -> None:
    """The opening is a rectangle: the lids are as far apart at its sides as in the middle."""
    gap = face.points[CONTROL_POINT_INDEX["eyelid_upper_l"], 1] - face.points[CONTROL_POINT_INDEX["eyelid_lower_l"], 1]
    helpers = helpers_on_edges(face.points, eyes_of_height(face, gap))
    inner = np.array([row % 6 in (1, 2, 3, 4) for row in range(24)])  # the outermost lie on the steps of the hole
    weights = np.array([helpers.weights[row, lid] for row, lid in enumerate(helpers.lids)])
    assert (weights[inner] > 0.8).all()
    assert helpers.weights.sum(axis=1) == pytest.approx(1)
    gaps = helpers.positions[:12, 1] - helpers.positions[12:, 1]  # of the parabola: 0.44 of the gap near the corners
    assert (gaps[inner[:12]] > 0.8 * gap).all()


def test_the_parabola_is_kept_without_edges(face: SheetFace) -> None:
    mesh = LabelledMesh(face.mesh.vertices, face.mesh.triangles, np.zeros(len(face.mesh.triangles), np.int32))
    measured, parabola = helpers_on_edges(face.points, mesh), helpers_on_parabola(face.points)
    lids = len(set(parabola.lids.tolist()))
    inner = [row for row in range(len(measured.lids)) if 0 < row % (len(measured.lids) // lids) < 5]
    assert measured.positions[inner].tolist() == parabola.positions.tolist()
    assert measured.weights[inner].tolist() == parabola.weights.tolist()


def test_brow_helpers_move_with_the_brow_and_not_with_the_lid(face: SheetFace) -> None:
    labels = np.zeros(len(face.mesh.triangles), np.int32)
    mesh = LabelledMesh(face.mesh.vertices, face.mesh.triangles, labels)
    lids = helpers_on_parabola(face.points)
    helpers = with_brow_helpers(lids, face.points, mesh)
    added = slice(len(lids.positions), None)
    assert helpers.weights[added].sum(axis=1) == pytest.approx(1)
    brows = control_point_indices("brow")
    assert helpers.weights[added][:, brows].sum(axis=1) == pytest.approx(1)
    assert set(helpers.lids[added].tolist()) <= set(brows)
    for position in helpers.positions[added]:
        side = "l" if position[0] > 0 else "r"
        lid, brow = (face.points[CONTROL_POINT_INDEX[f"{name}_{side}"], 1] for name in ("eyelid_upper", "brow_top"))
        assert lid < position[1] < brow + 1.0
    depth = cast_front_rays(helpers.positions[added, :2], mesh.vertices, mesh.triangles).points[:, 2]
    np.testing.assert_allclose(helpers.positions[added, 2], depth)

    closing = np.zeros((50, 1))
    closing[UPPER_LID] = -0.7
    moved = []
    for known in (lids, helpers):
        centres, fields = append_helpers(face.points, Regions.unrestricted(8), known)
        probes = helpers.positions[added][:8]
        operator = build_operator(probes, centres, kernel=KERNELS["multiquadric"], epsilon=1.0, regions=fields)
        moved.append(float(np.abs(fold_helpers(operator.matrix, known) @ closing).max()))
    assert moved[1] < 0.01 < 0.05 < moved[0]
