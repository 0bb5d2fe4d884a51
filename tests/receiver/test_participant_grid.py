from collections.abc import Mapping
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.face.deformation.face_model import FaceModel
from conf.protocol.messages import MotionFrame
from conf.receiver.heads.participant_heads import Look
from conf.receiver.participant_grid import ParticipantGrid, layout_grid
from conf.receiver.resolution_control import DrawingDetail
from conf.receiver.stats_overlay import covered_width
from conf.render.auto_framing import FrameArea, head_bounds, rest_pose
from conf.render.camera import ViewState
from conf.render.face_renderer import FaceRenderer
from conf.render.window.offscreen import OffscreenWindow
from tests.support.image_measures import box
from tests.support.stand_in_head import SIZE

COVERED = round(covered_width(SIZE, 1.0))


def motion(x: float = 0.0, y: float = 0.0, log_scale: float = -3.5) -> MotionFrame:
    return MotionFrame(0.0, np.zeros((50, 3), np.float32), np.array([0.0, 0.0, 0.0, x, y, log_scale]))


@pytest.mark.slow
@given(st.integers(1, 30), st.integers(64, 4000), st.integers(64, 4000), st.integers(0, 30))
def test_the_cells_tile_the_image(count: int, width: int, height: int, left: int) -> None:
    cells = layout_grid(count, (width, height), left=left)
    assert len(cells) == count
    assert sum(w * h for _, _, w, h in cells) == (width - left) * height
    assert all(left <= x < x + w <= width and 0 <= y < y + h <= height for x, y, w, h in cells)
    overlaps = [
        max(a[0], b[0]) < min(a[0] + a[2], b[0] + b[2]) and max(a[1], b[1]) < min(a[1] + a[3], b[1] + b[3])
        for i, a in enumerate(cells)
        for b in cells[:i]
    ]
    assert not any(overlaps)


@pytest.mark.parametrize(("count", "columns"), [(1, 1), (2, 2), (3, 2), (4, 2), (6, 3), (9, 3)])
def test_cells_are_about_square(count: int, columns: int) -> None:
    cells = layout_grid(count, (640, 480))
    assert len({x for x, y, _, _ in cells if y == cells[0][1]}) == columns


@pytest.mark.slow
def test_each_participant_is_drawn_in_the_cell_that_is_returned(window: OffscreenWindow, face: FaceModel) -> None:
    grid = ParticipantGrid(window, face)
    window.begin()
    cells = grid.draw({7: motion(-0.4), 9: None, 4: motion(0.4, 0.3, -4.5)}, ViewState(stats=False), 0.0)
    pixels = window.read().astype(int)
    grid.release()
    assert list(cells) == [7, 9, 4]
    assert list(cells.values()) == layout_grid(3, SIZE)
    for x, y, w, h in cells.values():
        cell = pixels[SIZE[1] - y - h : SIZE[1] - y, x : x + w]
        left, top, right, bottom = box(cell.sum(axis=2) > 300)  # lit skin
        assert 0 < left and right < w and 0 < top and bottom < h
        assert (left + right) / 2 == pytest.approx(w / 2, abs=w / 6)


@pytest.mark.slow
def test_without_participants_the_neutral_face_is_drawn(window: OffscreenWindow, face: FaceModel) -> None:
    grid = ParticipantGrid(window, face)
    window.begin()
    assert grid.draw({}, ViewState(), 0.0) == {}
    empty = window.read()
    window.begin()
    grid.draw({1: None}, ViewState(), 0.0)
    grid.release()
    np.testing.assert_array_equal(window.read(), empty)


@pytest.mark.slow
@pytest.mark.parametrize("participants", [1, 3])
def test_the_stats_overlay_covers_no_face(window: OffscreenWindow, face: FaceModel, participants: int) -> None:
    grid = ParticipantGrid(window, face)
    window.begin()
    grid.draw({i: motion() for i in range(participants)}, ViewState(stats=True), 0.0)
    left, _, right, _ = box(window.read().astype(int).sum(axis=2) > 300)
    grid.release()
    assert COVERED < left < right < SIZE[0]


@pytest.mark.slow
def test_without_centring_a_face_is_where_the_camera_saw_it(window: OffscreenWindow, face: FaceModel) -> None:
    centres = []
    for view in (ViewState(centred=False), ViewState(stats=False)):
        grid = ParticipantGrid(window, face)
        window.begin()
        grid.draw({1: motion(-0.3, 0.0, -4.0)}, view, 0.0)
        grid.release()
        left, _, right, _ = box(window.read().astype(int).sum(axis=2) > 300)
        centres.append((left + right) / 2)
    as_sent, centred = centres
    assert as_sent == pytest.approx(SIZE[0] / 2 - 0.3 * SIZE[1], abs=12)
    assert centred == pytest.approx(SIZE[0] / 2, abs=12)


@pytest.mark.slow
def test_the_framing_of_a_participant_who_left_is_dropped(window: OffscreenWindow, face: FaceModel) -> None:
    grid, view = ParticipantGrid(window, face), ViewState(stats=False)
    images = []
    for frames in ({1: motion(-0.4)}, {}, {1: motion(0.4)}):
        window.begin()
        grid.draw(frames, view, 0.0)
        images.append(window.read())
    grid.release()
    np.testing.assert_array_equal(images[0], images[2])


@pytest.mark.slow
def test_of_several_participants_those_that_moved_are_drawn_in_turn(
    window: OffscreenWindow, face: FaceModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[int] = []
    draw = FaceRenderer.draw

    def record(renderer: FaceRenderer, *args: Any, participant: int, **options: Any) -> None:
        drawn.append(participant)
        draw(renderer, *args, participant=participant, **options)

    monkeypatch.setattr(FaceRenderer, "draw", record)

    def drawn_in_frame(grid: ParticipantGrid, rotations: list[float], view: ViewState) -> list[int]:
        frames = {i: motion() for i in range(4)}
        for frame, rotation in zip(frames.values(), rotations, strict=True):
            frame.pose[1] = rotation
        drawn.clear()
        window.begin()
        grid.draw(frames, view, 0.0)
        return list(drawn)

    view = ViewState(centred=False)
    with ParticipantGrid(window, face) as grid:
        grid.detail = DrawingDetail(interval=2)
        assert drawn_in_frame(grid, [0.0] * 4, view) == [0, 1, 2, 3], "at first all of them"
        assert drawn_in_frame(grid, [0.0] * 4, view) == []
        first = window.read()
        assert drawn_in_frame(grid, [0.0, 0.3, 0.0, 0.0], view) == [1]
        changed = (window.read() != first).any(axis=2)
        assert changed[: SIZE[1] // 2, SIZE[0] // 2 :].any()
        assert not changed[SIZE[1] // 2 :].any() and not changed[:, : SIZE[0] // 2].any()
        assert drawn_in_frame(grid, [0.1] * 4, view) == [0, 2]
        assert drawn_in_frame(grid, [0.2] * 4, view) == [3, 1]
        assert drawn_in_frame(grid, [0.2] * 4, view) == [0, 2]
        assert drawn_in_frame(grid, [0.2] * 4, view) == []
        assert drawn_in_frame(grid, [0.2] * 4, ViewState(centred=False, zoom=2.0)) == [3, 1]
        in_turn = window.read()
        assert drawn_in_frame(grid, [0.2] * 4, ViewState(centred=False, zoom=2.0)) == [0, 2]
        at_last = window.read()
        assert (at_last != in_turn).any()
    with ParticipantGrid(window, face) as grid:
        drawn_in_frame(grid, [0.2] * 4, ViewState(centred=False, zoom=2.0))
        np.testing.assert_array_equal(window.read(), at_last)


@pytest.mark.slow
def test_a_new_layout_draws_all_cells_at_once(window: OffscreenWindow, face: FaceModel) -> None:
    images = []
    for earlier in ((4, ViewState()), None):
        with ParticipantGrid(window, face) as grid:
            grid.detail = DrawingDetail(interval=3)
            for count, view in [earlier, (3, ViewState(stats=True))] if earlier else [(3, ViewState(stats=True))]:
                window.begin()
                grid.draw({i: motion() for i in range(count)}, view, 0.0)
            images.append(window.read())
    np.testing.assert_array_equal(images[0], images[1])


def test_the_head_at_rest_leaves_room_for_hair() -> None:
    centre, half = head_bounds(rest_pose(FrameArea.of((640, 480))))
    assert (centre + half)[1] < 0.45 and (centre - half)[1] < -0.25


@pytest.mark.slow
def test_the_grid_tells_whether_a_photo_is_drawn(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, face: FaceModel
) -> None:
    monkeypatch.setattr(
        "conf.receiver.portrait.portrait_renderer.PortraitRenderer", lambda ctx, store: Mock(store=store)
    )
    grid = ParticipantGrid(window, face)
    grid.receive_portrait_object(7, b"not a photo")
    shown: list[bool] = []
    frames: Mapping[int, MotionFrame | None]
    for frames, view in (
        ({7: motion()}, ViewState()),
        ({7: motion()}, ViewState(portrait=False)),
        ({7: motion()}, ViewState()),
        ({7: None}, ViewState()),
        ({9: motion()}, ViewState()),
    ):
        window.begin()
        grid.withdrawn = {7} if len(shown) == 2 else ()
        grid.draw(frames, view, 0.0)
        shown.append(grid.shows_photo)
    grid.release()
    assert shown == [True, False, False, False, False]


@pytest.mark.slow
def test_an_inset_is_drawn_over_the_image_and_keeps_its_portrait(window: OffscreenWindow, face: FaceModel) -> None:
    grid = ParticipantGrid(window, face)
    cell = (10, 20, 48, 36)
    window.begin()
    grid.draw({0: motion()}, ViewState(), 0.0)
    before = window.read().astype(int)
    grid.receive_portrait_object(-2, b"no object")
    grid.draw_inset(-2, motion(), cell, 0.0, photo=True)
    after = window.read().astype(int)
    x, y, w, h = cell
    inside = np.zeros(after.shape[:2], bool)
    inside[SIZE[1] - y - h : SIZE[1] - y, x : x + w] = True
    changed = (after != before).any(axis=2)
    assert changed[inside].mean() > 0.3 and not changed[~inside].any()
    grid.draw({0: motion()}, ViewState(), 0.1)
    assert -2 in grid._portraits
    grid.release()


def test_nothing_is_left_of_a_participant_who_is_forgotten(
    window: OffscreenWindow, face: FaceModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    released = Mock()
    monkeypatch.setattr(
        "conf.receiver.portrait.portrait_renderer.PortraitRenderer", lambda ctx, store: Mock(release=released)
    )
    grid = ParticipantGrid(window, face)
    grid.receive_portrait_object(0, b"no object")
    grid.looks = {0: Look(), 1: Look()}
    grid.forget(0)
    assert not grid._portraits and grid.looks.keys() == {1}
    released.assert_called_once_with()
    grid.forget(0)
    grid.release()
