import numpy as np
import pytest
import trimesh

from conf.face.mesh.orientation import closed_inside_out, consistent_flips, weld_indices

BALL = trimesh.creation.icosphere(subdivisions=2)
POSITIONS, TRIANGLES = np.asarray(BALL.vertices), np.asarray(BALL.faces)


def test_a_consistent_surface_is_left_alone_whichever_way_it_faces() -> None:
    assert not consistent_flips(POSITIONS, TRIANGLES).any()
    assert not consistent_flips(POSITIONS, TRIANGLES[:, ::-1]).any()


def test_the_winding_of_most_of_the_area_wins() -> None:
    few = np.arange(len(TRIANGLES)) % 3 == 0
    mixed = np.where(few[:, None], TRIANGLES[:, ::-1], TRIANGLES)
    np.testing.assert_array_equal(consistent_flips(POSITIONS, mixed), few)
    mixed = np.where(few[:, None], TRIANGLES, TRIANGLES[:, ::-1])
    np.testing.assert_array_equal(consistent_flips(POSITIONS, mixed), few)


def test_repeated_vertices_are_joined() -> None:
    few = np.arange(len(TRIANGLES)) % 4 == 0
    mixed = np.where(few[:, None], TRIANGLES[:, ::-1], TRIANGLES)
    soup, numbers = POSITIONS[mixed.ravel()], np.arange(3 * len(mixed)).reshape(-1, 3)
    np.testing.assert_array_equal(consistent_flips(soup, numbers), few)
    assert len(np.unique(weld_indices(soup))) == len(POSITIONS)
    assert weld_indices(np.array([[0.0, 0, 0], [-0.0, 0, 0], [0, 1, 0]])).tolist() in ([0, 0, 1], [1, 1, 0])


def test_a_sheet_with_both_sides_and_a_moebius_strip_are_left_alone() -> None:
    both = np.concatenate([TRIANGLES, TRIANGLES[:, ::-1]])
    assert not consistent_flips(POSITIONS, both).any()
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    centre = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    across = 0.3 * np.stack(
        [np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)], 1
    )
    strip = np.concatenate([centre - across, centre + across])
    next_a, next_b = np.r_[1:12, 12], np.r_[13:24, 0]
    triangles = np.concatenate(
        [np.stack([np.arange(12), next_a, next_b], 1), np.stack([np.arange(12), next_b, np.arange(12, 24)], 1)]
    )
    assert not consistent_flips(strip, triangles).any()


@pytest.mark.parametrize("inverted", [0, 1])
def test_a_closed_part_that_is_inside_out_is_found(inverted: int) -> None:
    parts = [TRIANGLES, TRIANGLES + len(POSITIONS)]
    parts[inverted] = parts[inverted][:, ::-1]
    found = closed_inside_out(np.concatenate([POSITIONS, POSITIONS + 5]), np.concatenate(parts))
    assert found.reshape(2, -1).all(axis=1).tolist() == [inverted == 0, inverted == 1]
    assert not closed_inside_out(POSITIONS, TRIANGLES[1:, ::-1]).any(), "an open surface has no volume"
