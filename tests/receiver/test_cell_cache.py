from dataclasses import replace

import numpy as np
import pytest

from conf.face.head_pose import NEUTRAL_POSE
from conf.receiver.cell_cache import CellCache, CellContent
from conf.render.camera import ViewState
from conf.render.window.offscreen import OffscreenWindow

STILL = CellContent(np.zeros((50, 3), np.float32), NEUTRAL_POSE, ViewState(), (1.0,))


def test_contents_with_the_same_image_are_alike() -> None:
    moved = np.zeros((50, 3), np.float32)
    moved[7, 1] = 1.0
    nodding = replace(NEUTRAL_POSE, rotation=np.array([0.001, 0.0, 0.0]))
    assert STILL.looks_like(replace(STILL, displacements=np.zeros((50, 3), np.float32)))
    assert STILL.looks_like(replace(STILL, furrow=0.005))
    assert STILL.looks_like(replace(STILL, pose=replace(NEUTRAL_POSE, position=np.array([5e-5, 0.0]))))
    for other in (
        replace(STILL, displacements=moved),
        replace(STILL, displacements=None),
        replace(STILL, pose=nodding),
        replace(STILL, pose=replace(NEUTRAL_POSE, log_scale=NEUTRAL_POSE.log_scale + 0.001)),
        replace(STILL, view=ViewState(zoom=2.0)),
        replace(STILL, version=(0.5,)),
        replace(STILL, furrow=0.1),
    ):
        assert not STILL.looks_like(other) and not other.looks_like(STILL)
    assert replace(STILL, displacements=None).looks_like(replace(STILL, displacements=None))


def test_the_cells_that_were_drawn_longest_ago_come_first(window: OffscreenWindow) -> None:
    with CellCache(window.ctx, {5: (0, 0, 1, 1), 3: (1, 0, 1, 1), 9: (2, 0, 1, 1)}, (3, 1)) as cache:
        assert cache.by_age() == [5, 3, 9]
        cache.on_drawn(3, STILL)
        assert cache.by_age() == [5, 9, 3] and not cache.is_complete
        cache.on_drawn(9, STILL)
        cache.on_drawn(5, STILL)
        cache.on_drawn(3, STILL)
        assert cache.by_age() == [9, 5, 3] and cache.is_complete
        assert cache.shows(3, STILL) and not cache.shows(3, replace(STILL, displacements=None))


@pytest.mark.slow
def test_the_cells_are_copied_into_the_window(window: OffscreenWindow) -> None:
    width, height = window.size
    with CellCache(window.ctx, {1: (0, 0, width, height)}, window.size) as cache:
        cache.framebuffer.clear(1.0, 0.0, 0.0)
        cache.framebuffer.clear(0.0, 0.0, 1.0, viewport=(0, 0, width // 2, height // 2))
        window.begin()
        cache.copy_to(window.framebuffer)
        pixels = window.read()
    assert (pixels[height // 2 :, : width // 2] == (255, 0, 0)).all()  # BGR; the first row is on top
    assert (pixels[: height // 2] == (0, 0, 255)).all() and (pixels[:, width // 2 :] == (0, 0, 255)).all()
