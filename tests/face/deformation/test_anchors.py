import numpy as np

from conf.face.deformation.anchors import choose_anchors
from tests.support.sheet_face import SheetFace


def test_anchors_are_vertices_far_from_the_control_points(face: SheetFace) -> None:
    anchors = choose_anchors(face.mesh.vertices, face.points, eye_distance=6.4)
    assert 5 < len(anchors) <= 32
    assert all((anchor == face.mesh.vertices).all(axis=1).any() for anchor in anchors)
    to_points = np.linalg.norm(anchors[:, None] - face.points, axis=-1)
    assert to_points.min() > 0.55 * 6.4


def test_initial_anchors_come_first_and_others_keep_their_distance(face: SheetFace) -> None:
    initial = np.array([[11.0, 12.0, 0.0], [-11.0, 12.0, 0.0]])
    anchors = choose_anchors(face.mesh.vertices, face.points, eye_distance=6.4, initial=initial)
    assert anchors[:2].tolist() == initial.tolist()
    assert np.linalg.norm(anchors[2:, None] - initial, axis=-1).min() > 0.55 * 6.4


def test_a_mask_that_ends_with_its_points_has_no_anchors(face: SheetFace) -> None:
    assert choose_anchors(face.points, face.points, eye_distance=6.4).shape == (0, 3)


def test_anchors_do_not_depend_on_the_unit(face: SheetFace) -> None:
    cm = choose_anchors(face.mesh.vertices, face.points, eye_distance=6.4)
    mm = choose_anchors(face.mesh.vertices * 8, face.points * 8, eye_distance=51.2)
    assert (mm / 8 == cm).all()
