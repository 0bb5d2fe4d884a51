import numpy as np
import pytest

from conf.face.default_head import DEFAULT_HEAD, default_joints, default_points
from conf.face.deformation.blendshapes import load_blendshapes
from conf.face.deformation.face_model import DeformerOptions
from conf.face.deformation.operator_builder import OperatorBuilder, choose_anchors
from conf.face.deformation.rbf import KERNELS
from conf.face.deformation.rig_builder import build_rig
from conf.face.mesh.mesh import load_mesh
from conf.face.similarity import SimilarityTransform
from tests.support.sheet_face import SheetFace


@pytest.fixture(scope="module")
def builder() -> OperatorBuilder:
    """Return the builder of the default head."""
    mesh, points = load_mesh(DEFAULT_HEAD), default_points()
    blendshapes = load_blendshapes(DEFAULT_HEAD.with_name("shapes.npz"), len(mesh.vertices))
    rig = build_rig(mesh, points, default_joints(), blendshapes)
    return OperatorBuilder(mesh, points, rig, blendshapes)


@pytest.mark.slow
@pytest.mark.parametrize("kernel", KERNELS)
def test_every_kernel_keeps_the_neutral_face_still(builder: OperatorBuilder, kernel: str) -> None:
    face = builder.build_face(DeformerOptions(kernel))
    assert np.isfinite(face.operator).all()
    skin = face.mesh.group_vertices("skin")
    np.testing.assert_allclose(face.deform(np.zeros((50, 3)))[skin], face.neutral[skin], atol=1e-5)


@pytest.mark.slow
def test_each_option_changes_the_operator(builder: OperatorBuilder) -> None:
    default = builder.build(DeformerOptions()).matrix
    for options in (
        DeformerOptions(epsilon=0.5),
        DeformerOptions(degree=1),
        DeformerOptions(smoothing=0.1),
        DeformerOptions(use_regions=False),
        DeformerOptions(use_ridge_refinement=False),
    ):
        assert np.abs(builder.build(options).matrix - default).max() > 1e-3
    np.testing.assert_array_equal(builder.build(DeformerOptions()).matrix, default)


@pytest.mark.slow
def test_rigid_parts_are_not_moved_by_the_operator(builder: OperatorBuilder) -> None:
    face = builder.build_face(DeformerOptions())
    assert face.rig is not None
    assert not face.operator[face.rig.rigid].any()


@pytest.mark.slow
def test_a_face_holds_what_it_was_built_from(face: SheetFace) -> None:
    transform = SimilarityTransform(np.eye(3), 10.0, np.zeros(3))
    builder = OperatorBuilder(face.mesh, face.points, file_to_model=transform)
    options = DeformerOptions("gaussian", epsilon=0.05, smoothing=0.0, use_regions=False)
    built, operator = builder.build_face(options), builder.build(options)
    assert (built.mesh, built.control_points, built.rig) == (face.mesh, face.points, None)
    assert built.file_to_model is transform
    assert built.smoothing == operator.smoothing > 0
    np.testing.assert_array_equal(built.operator, operator.matrix)
    assert np.abs(operator.matrix - builder.build(DeformerOptions("gaussian", degree=1)).matrix).max() > 1e-3


@pytest.mark.slow
def test_a_singular_system_is_regularised(builder: OperatorBuilder) -> None:
    operator = builder.build(DeformerOptions("gaussian", epsilon=0.05, smoothing=0.0))
    assert operator.smoothing > 0
    assert np.isfinite(operator.matrix).all()


def test_an_unknown_kernel_raises(builder: OperatorBuilder) -> None:
    with pytest.raises(ValueError, match=r"kernel must be one of gaussian, multiquadric, .*, got 'cubic'"):
        builder.build(DeformerOptions("cubic"))


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


def test_anchors_are_the_farthest_vertices_first_until_all_are_near_one(face: SheetFace) -> None:
    vertices, limit = face.mesh.vertices[::12], 0.55 * 8.0
    anchors = choose_anchors(vertices, face.points, eye_distance=8.0)
    assert 10 < len(anchors) < 32
    fixed = face.points
    for anchor in anchors:
        distances = np.linalg.norm(vertices[:, None] - fixed, axis=-1).min(axis=1)
        assert np.linalg.norm(anchor - fixed, axis=1).min() == pytest.approx(distances.max())
        assert distances.max() > limit
        fixed = np.concatenate([fixed, [anchor]])
    assert np.linalg.norm(vertices[:, None] - fixed, axis=-1).min(axis=1).max() <= limit


def test_a_mask_that_ends_with_its_points_has_no_anchors(face: SheetFace) -> None:
    assert choose_anchors(face.points, face.points, eye_distance=6.4).shape == (0, 3)


def test_anchors_do_not_depend_on_the_unit(face: SheetFace) -> None:
    cm = choose_anchors(face.mesh.vertices, face.points, eye_distance=6.4)
    mm = choose_anchors(face.mesh.vertices * 8, face.points * 8, eye_distance=51.2)
    assert (mm / 8 == cm).all()
