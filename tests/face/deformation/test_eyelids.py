from dataclasses import replace

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.default_head import DEFAULT_HEAD, default_joints, default_points
from conf.face.deformation.eyelids import (
    Lashes,
    curve_weights,
    find_lashes,
    find_lid_cover,
    rotation_between,
    stop_at_contact,
)
from conf.face.mesh.editing import submesh
from conf.face.mesh.mesh import Mesh, load_mesh

UPPER, LOWER = CONTROL_POINT_INDEX["eyelid_upper_l"], CONTROL_POINT_INDEX["eyelid_lower_l"]
CENTRE = np.array([3.2, 2.8452, 2.0499])


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    """Return the default head."""
    return load_mesh(DEFAULT_HEAD)


def left_lashes(mesh: Mesh) -> Lashes | None:
    skin = np.setdiff1d(np.arange(len(mesh.vertices)), mesh.group_vertices("eye_l", "eye_r"))
    return find_lashes(mesh, default_points(), default_joints().eyes["eye_l"], skin, side="l")


def test_an_upper_lid_stops_where_it_barely_covers_the_lower() -> None:
    points, offsets = default_points(), np.zeros((50, 3), np.float32)
    gap = points[UPPER, 1] - points[LOWER, 1]
    for lower, upper in ((0.0, -1.4 * gap), (0.0, -3 * gap), (0.2 * gap, -1.2 * gap)):
        offsets[[UPPER, LOWER], 1] = upper, lower
        stopped = stop_at_contact(points, offsets)
        assert points[UPPER, 1] + stopped[UPPER, 1] - points[LOWER, 1] - stopped[LOWER, 1] == pytest.approx(-0.06 * gap)
        assert np.delete(stopped, UPPER, axis=0).tolist() == np.delete(offsets, UPPER, axis=0).tolist()
    offsets[[UPPER, LOWER], 1] = -gap, 0
    assert stop_at_contact(points, offsets) is offsets


def test_lids_that_overlap_in_the_neutral_pose_stay_so() -> None:
    points = default_points().copy()
    points[UPPER, 1] = points[LOWER, 1] - 0.3
    assert not stop_at_contact(points, np.zeros((50, 3), np.float32)).any()


def test_the_rotation_between_two_vectors_turns_in_their_plane() -> None:
    before, after = np.array([0, 0, 2.0], np.float32), np.array([0, -2.0, 0], np.float32)
    vector = np.array([0.5, 0, 1.0])
    assert rotation_between(before, after, 1.0) @ vector == pytest.approx([0.5, -1, 0], abs=1e-6)
    assert rotation_between(before, after, 2.0) @ vector == pytest.approx([0.5, 0, -1], abs=1e-6)
    assert rotation_between(before, 3 * before, 1.5) == pytest.approx(np.eye(3))
    oblique = rotation_between(np.array([1, 2, 3], np.float32), np.array([-1, 0, 2], np.float32), 1.3)
    assert oblique @ oblique.T == pytest.approx(np.eye(3), abs=1e-6)


def test_curve_weights_reproduce_cubics_and_hold_the_ends() -> None:
    samples = np.linspace(-0.8, 0.9, 9)
    weights = curve_weights(np.array([-2.0, 0.1, 0.9, 5.0]), samples)
    assert weights @ (samples**3 - samples) == pytest.approx([0.288, -0.099, -0.171, -0.171])
    assert weights.sum(axis=1) == pytest.approx(1)
    assert curve_weights(np.array([0.3]), np.array([0.5])).tolist() == [[pytest.approx(1)]]


def test_the_lashes_of_an_eye_are_found_by_their_shape(mesh: Mesh) -> None:
    nameless = replace(mesh, groups={name: mesh.groups[name] for name in ("eye_l", "eye_r")})
    lashes = left_lashes(nameless)
    assert lashes is not None
    own = mesh.group_vertices("lashes")
    assert lashes.vertices.tolist() == own[mesh.vertices[own, 0] > 0].tolist()
    heights = mesh.vertices[lashes.vertices, 1]
    assert lashes.lids.sum() == len(own) / 4
    assert heights[lashes.lids == 1].max() < heights[lashes.lids == 0].min() + 0.05
    assert set(lashes.attached.tolist()) < set(lashes.vertices.tolist())
    assert lashes.weights.sum(axis=1) == pytest.approx(1, abs=1e-4)


def test_brows_and_skin_are_no_lashes(mesh: Mesh) -> None:
    kept = np.ones(len(mesh.triangles), np.bool_)
    kept[mesh.groups["lashes"]] = False
    assert left_lashes(submesh(mesh, kept)) is None


def test_lashes_rest_in_the_neutral_pose_and_turn_down_with_the_lid(mesh: Mesh) -> None:
    lashes = left_lashes(mesh)
    assert lashes is not None
    neutral, centre = mesh.vertices.astype(np.float32), CENTRE.astype(np.float32)
    moved = neutral.copy()
    lashes.apply(neutral, moved, centre)
    assert moved == pytest.approx(neutral, abs=1e-5)
    upper = lashes.vertices[lashes.lids == 0]
    angle = np.radians(35)  # of the lid around the eye, as in a blink
    rotation = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    moved[upper] = neutral[upper] + ((neutral[upper] - centre) @ rotation.T - (neutral[upper] - centre)).mean(axis=0)
    tips, roots = upper[neutral[upper, 2].argmax()], upper[np.abs(neutral[upper] - [3.24, 3.21, 3.94]).sum(1).argmin()]
    assert (moved[tips] - moved[roots])[1] > 0.25  # they only move: they stand upright
    lashes.apply(neutral, moved, centre)
    assert (moved[tips] - moved[roots])[1] < 0.0
    length = np.linalg.norm(neutral[tips] - neutral[roots])
    assert np.linalg.norm(moved[tips] - moved[roots]) == pytest.approx(length, rel=0.1)


def test_a_lid_that_overlaps_pushes_the_lashes_of_the_lower_one_down(mesh: Mesh) -> None:
    lashes = left_lashes(mesh)
    assert lashes is not None
    neutral = mesh.vertices.astype(np.float32)
    upper, lower = lashes.vertices[lashes.lids == 0], lashes.vertices[lashes.lids == 1]
    gap = float(np.subtract(*(lashes.middles @ neutral[lashes.attached])[:, 1]))
    assert 0.7 < gap < 1.3
    for down, expected in ((gap - 0.1, 0.0), (gap + 0.15, -0.15)):
        moved = neutral.copy()
        moved[upper, 1] -= np.float32(down)
        lashes.apply(neutral, moved, CENTRE.astype(np.float32))
        assert moved[lower, 1] - neutral[lower, 1] == pytest.approx(expected, abs=1e-4)


def test_the_edge_of_a_closed_upper_lid_stands_out(mesh: Mesh) -> None:
    points, skin = default_points(), mesh.group_vertices("skin")
    cover = find_lid_cover(mesh, points, skin, side="l")
    assert cover is not None
    neutral, centre = mesh.vertices.astype(np.float32), CENTRE.astype(np.float32)
    assert cover.distances.max() == pytest.approx(0.08, abs=0.02)
    assert (neutral[cover.vertices, 1] > points[LOWER, 1] + 0.2).all()
    corners = points[[CONTROL_POINT_INDEX["eye_outer_corner_l"], CONTROL_POINT_INDEX["eye_inner_corner_l"]]]
    for corner in corners:
        near = np.linalg.norm(neutral[cover.vertices] - corner, axis=1) < 0.15
        assert cover.distances[near].max(initial=0.0) < 0.03
    for closed, amount in ((0.0, 0.0), (0.5, 0.0), (0.65, 0.5), (1.0, 1.0)):
        moved = neutral.copy()
        moved[cover.vertices, 1] -= np.float32(closed * cover.travel)
        before = np.linalg.norm(moved[cover.vertices] - centre, axis=1)
        rest = moved.copy()
        cover.apply(neutral, moved, centre)
        after = np.linalg.norm(moved[cover.vertices] - centre, axis=1)
        assert after - before == pytest.approx(amount * cover.distances, abs=1e-4)
        others = np.setdiff1d(np.arange(len(moved)), cover.vertices)
        assert (moved[others] == rest[others]).all()


def test_lids_that_are_closed_have_no_cover(mesh: Mesh) -> None:
    points = default_points().copy()
    points[UPPER] = points[LOWER]
    assert find_lid_cover(mesh, points, mesh.group_vertices("skin"), side="l") is None


def test_lashes_in_several_parts_turn_alike(mesh: Mesh) -> None:
    """Each lash may be a card of its own: those at the corners turn with the middle of their lid."""
    own, whole = mesh.group_vertices("lashes"), left_lashes(mesh)
    assert whole is not None
    centres = mesh.vertices[mesh.triangles[mesh.groups["lashes"]]].mean(axis=1)
    is_cut = np.zeros(len(mesh.triangles), np.bool_)
    is_cut[mesh.groups["lashes"][np.abs(centres[:, 0] - 4.0) < 0.15]] = True  # a gap beside the middle of the eye
    parts = left_lashes(submesh(mesh, ~is_cut))
    assert parts is not None
    assert len(own) / 2 - 20 < len(parts.vertices) < len(own) / 2
    assert parts.middles.sum(axis=1) == pytest.approx(1, abs=1e-4)
    labels = np.unique(parts.middles.any(axis=0) * 1)
    assert labels.tolist() == [0, 1]  # the outer part has no influence on the rotation
