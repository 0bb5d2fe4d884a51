"""Every shipped head keeps what the default head keeps: closed lips, lids that close, teeth inside, lashes outside."""

from pathlib import Path

import numpy as np
import pytest

from conf.errors import FileFormatError
from conf.face.animation.action_units import combine_action_units
from conf.face.animation.gaze import gaze_displacements
from conf.face.control_points import CONTROL_POINT_INDEX, CONTROL_POINTS
from conf.face.default_head import DEFAULT_HEAD
from conf.face.deformation.blendshapes import load_blendshapes
from conf.face.deformation.face_model import FaceModel
from conf.face.head_catalogue import HEADS, HEADS_BY_NAME
from conf.face.head_pose import ES0_CM
from conf.face.head_variant import read_head_variant
from conf.face.loading import load_head
from conf.face.mesh.mesh import load_mesh
from conf.face.mesh.raycast import cast_front_rays

OPEN, SMILE = {26: 1.0}, {6: 0.7, 12: 1.0}


@pytest.fixture(scope="module", params=HEADS, ids=lambda head: head.name)
def face(request: pytest.FixtureRequest) -> FaceModel:
    return load_head(request.param)


def visible(face: FaceModel, vertices: np.ndarray, *groups: str, step: float = 0.05) -> float:
    """Return the area, cm2, of groups that is visible from the front."""
    members = vertices[face.mesh.group_vertices(*groups)]
    low, high = members.min(axis=0) - step, members.max(axis=0) + step
    x, y = np.meshgrid(np.arange(low[0], high[0], step), np.arange(low[1], high[1], step))
    solid = [name for name in face.mesh.groups if name not in ("hair", "lashes")]
    triangles = face.mesh.triangles[np.concatenate([face.mesh.groups[name] for name in solid])]
    owners = np.concatenate([np.full(len(face.mesh.groups[name]), name in groups) for name in solid])
    hits = cast_front_rays(np.stack([x.ravel(), y.ravel()], 1), vertices.astype(np.float64), triangles)
    return float(owners[hits.triangles[hits.triangles >= 0]].sum() * step**2)


@pytest.mark.slow
def test_it_has_the_groups_and_the_eye_distance_of_the_default_head(face: FaceModel) -> None:
    assert set(face.mesh.groups) - {"hair"} == set(load_mesh(DEFAULT_HEAD).groups) - {"hair"}
    assert face.fapu.es0 == pytest.approx(ES0_CM, abs=0.01)
    assert face.rig is not None and face.rig.jaw is not None and len(face.rig.eyes) == 2
    for point in CONTROL_POINTS:
        distance = np.linalg.norm(face.neutral - face.control_points[point.index], axis=1).min()
        assert distance < 0.02, point.name


@pytest.mark.slow
def test_both_sides_are_alike(face: FaceModel) -> None:
    for point in CONTROL_POINTS:
        if point.name.endswith("_l"):
            other = face.control_points[CONTROL_POINT_INDEX[point.name[:-2] + "_r"]]
            assert np.abs(face.control_points[point.index] - other * [-1, 1, 1]).max() < 0.06, point.name


@pytest.mark.slow
@pytest.mark.parametrize("closure", [1.0, 1.5])
def test_a_blink_leaves_no_slit(face: FaceModel, closure: float) -> None:
    open_area = visible(face, face.neutral, "eye_l", "eye_r")
    assert open_area > 2.0
    for gaze in (0.0, 0.3):
        shut = face.deform(closure * combine_action_units({45: 1.0}) + gaze_displacements(gaze, 0.0))
        assert visible(face, shut, "eye_l", "eye_r") < 0.02 * open_area


@pytest.mark.slow
def test_a_closed_mouth_shows_no_teeth_and_an_open_one_does(face: FaceModel) -> None:
    teeth = ("teeth_upper", "teeth_lower")
    assert visible(face, face.neutral, *teeth) < 0.02
    assert visible(face, face.deform(combine_action_units(SMILE)), *teeth) < 2.5
    assert 0.1 < visible(face, face.deform(combine_action_units(OPEN)), *teeth) < 6.0


@pytest.mark.slow
def test_teeth_stay_behind_the_lips(face: FaceModel) -> None:
    """From the sides of the mouth too: no tooth is in front of the lips at its height."""
    for units in ({}, SMILE, OPEN, {15: 1.0, 23: 1.0}):
        vertices = face.deform(combine_action_units(units))
        lips = [CONTROL_POINT_INDEX[name] for name in ("outer_lip_upper_mid", "outer_lip_lower_mid")]
        front = face.deformed_points(combine_action_units(units))[lips, 2].max()
        assert vertices[face.mesh.group_vertices("teeth_upper", "teeth_lower"), 2].max() < front


@pytest.mark.slow
def test_lashes_turn_down_with_shut_lids(face: FaceModel) -> None:
    lashes = face.mesh.group_vertices("lashes")
    upper = lashes[face.neutral[lashes, 1] > np.median(face.neutral[lashes, 1])]
    tips = upper[face.neutral[upper, 2] > np.quantile(face.neutral[upper, 2], 0.7)]
    shut = face.deform(combine_action_units({45: 1.0}))
    assert (face.neutral - shut)[tips, 1].mean() > 0.7 * face.fapu.irisd0


def test_hair_is_drawn_from_the_lowest_to_the_highest() -> None:
    """Both triangles of a quad come one after the other: a half drawn late would be hidden by what lies over it."""
    default = load_mesh(DEFAULT_HEAD)
    shapes = load_blendshapes(DEFAULT_HEAD.with_name("shapes.npz"), len(default.vertices))
    mesh = read_head_variant(HEADS_BY_NAME["maria"].path, default, shapes).mesh
    quads = mesh.triangles[mesh.groups["hair"]].reshape(-1, 2, 3)
    assert all(len(np.intersect1d(first, second)) == 2 for first, second in quads)


def test_a_file_that_is_no_head_is_explained(tmp_path: Path) -> None:
    default = load_mesh(DEFAULT_HEAD)
    shapes = load_blendshapes(DEFAULT_HEAD.with_name("shapes.npz"), len(default.vertices))
    good = next(head for head in HEADS if not head.is_default).path
    data = good.read_bytes()
    for content in (b"", b"PK", data[: len(data) // 2], b"\0" * 100):
        (tmp_path / "head.npz").write_bytes(content)
        with pytest.raises(FileFormatError, match="expected a head of this version: install conf again"):
            read_head_variant(tmp_path / "head.npz", default, shapes)
    with pytest.raises(FileFormatError, match="install conf again"):
        read_head_variant(tmp_path / "missing.npz", default, shapes)
