import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.face.head_pose import HeadPose
from conf.render.camera import ViewState, clip_matrix, project
from conf.render.drawn_area import BANDS, BORDER, STRETCH, Rectangle, complement, covered_bands, longest_edges

SIZE = (320, 240)


def painted(
    rectangles: list[Rectangle], size: tuple[int, int] = SIZE
) -> "np.ndarray[tuple[int, int], np.dtype[np.int_]]":
    """Return (H, W) how often each pixel is covered, the bottom row first."""
    counts = np.zeros(size[::-1], int)
    for left, bottom, width, height in rectangles:
        assert width > 0 and height > 0 and left >= 0 and bottom >= 0
        counts[bottom : bottom + height, left : left + width] += 1
    return counts


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.floats(0.2, 8.0), st.floats(-0.7, 0.7))
def test_the_bands_contain_every_vertex_in_the_image(seed: int, zoom: float, shift: float) -> None:
    rng = np.random.default_rng(seed)
    vertices = rng.uniform(-12, 12, (60, 3))
    pose = HeadPose(rng.uniform(-1, 1, 3), np.array([shift, -shift / 2]), float(np.log(0.03)))
    clip = clip_matrix(pose, ViewState(zoom=zoom), aspect=SIZE[0] / SIZE[1])
    bands = covered_bands(vertices, clip, SIZE, edges=np.zeros(60, np.float32))
    counts = painted(bands)
    assert counts.max(initial=0) <= 1
    x, y = project(vertices, clip, SIZE).T
    column, row = np.floor(x).astype(int), np.floor(SIZE[1] - y).astype(int)
    seen = (column >= 0) & (column < SIZE[0]) & (row >= 0) & (row < SIZE[1])
    assert (counts[row[seen], column[seen]] == 1).all()


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1))
def test_bands_and_complement_tile_the_image(seed: int) -> None:
    rng = np.random.default_rng(seed)
    clip = clip_matrix(HeadPose(np.zeros(3), np.zeros(2), float(np.log(0.02))), ViewState(), aspect=SIZE[0] / SIZE[1])
    bands = covered_bands(rng.uniform(-15, 15, (20, 3)), clip, SIZE, edges=np.full(20, 4.0, np.float32))
    assert (painted([*bands, *complement(bands, SIZE)]) == 1).all()


def test_a_narrow_part_above_a_wide_one_gets_a_narrow_band() -> None:
    clip = clip_matrix(HeadPose(np.zeros(3), np.zeros(2), float(np.log(0.02))), ViewState(), aspect=SIZE[0] / SIZE[1])
    head = np.array([(x, y, 0.0) for x in (-4.0, 4.0) for y in np.linspace(0, 20, 40)])
    shoulders = np.array([(x, y, 0.0) for x in (-25.0, 25.0) for y in np.linspace(-20, -10, 20)])
    bands = covered_bands(np.concatenate([head, shoulders]), clip, SIZE, edges=np.ones(1, np.float32))
    assert len(bands) == BANDS
    widths = [width for _, _, width, _ in bands]
    assert widths[0] == pytest.approx(50 * 0.02 * 240, abs=2 * BORDER + 12) and widths[-1] < 60


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.floats(0.2, 8.0))
def test_the_bands_contain_every_point_of_every_triangle(seed: int, zoom: float) -> None:
    rng = np.random.default_rng(seed)
    centres = rng.uniform(-12, 12, (20, 1, 3))
    vertices = (centres + rng.uniform(-3, 3, (20, 3, 3))).reshape(-1, 3)
    triangles = np.arange(60).reshape(-1, 3)
    clip = clip_matrix(HeadPose(np.zeros(3), np.zeros(2), float(np.log(0.03))), ViewState(zoom=zoom), aspect=4 / 3)
    bands = covered_bands(vertices, clip, SIZE, edges=longest_edges(vertices, triangles))
    weights = rng.dirichlet(np.ones(3), 40)
    points = np.einsum("pc,fcd->fpd", weights, vertices[triangles]).reshape(-1, 3)
    x, y = project(points, clip, SIZE).T
    column, row = np.floor(x).astype(int), np.floor(SIZE[1] - y).astype(int)
    seen = (column >= 0) & (column < SIZE[0]) & (row >= 0) & (row < SIZE[1])
    assert (painted(bands)[row[seen], column[seen]] == 1).all()


def test_the_longest_edge_at_each_vertex_is_found() -> None:
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0], [9, 9, 9]])
    found = longest_edges(vertices, np.array([[0, 1, 2]]))
    np.testing.assert_allclose(found, STRETCH * np.array([5**0.5, 5**0.5, 5**0.5, 0]), rtol=1e-6)


def test_nothing_drawn_has_no_bands_and_a_vertex_behind_the_camera_takes_the_whole_image() -> None:
    clip = clip_matrix(HeadPose(np.zeros(3), np.array([5.0, 0.0]), float(np.log(0.02))), ViewState(), aspect=4 / 3)
    assert covered_bands(np.zeros((3, 3)), clip, SIZE, edges=np.ones(1, np.float32)) == []
    assert covered_bands(np.array([[0.0, 0.0, 500.0]]), clip, SIZE, edges=np.ones(1, np.float32)) == [(0, 0, *SIZE)]
    assert complement([], SIZE) == [(0, 0, *SIZE)]
