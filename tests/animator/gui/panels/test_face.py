from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from conf.animator.background_fit import Axes, BackgroundFit, FitResult
from conf.animator.gui.panels import face as module
from conf.animator.gui.panels.face import draw_face
from conf.animator.state.point_placement import LEFT_POINTS, PointPlacement
from tests.animator.conftest import NOW, PanelDriver

pytestmark = pytest.mark.slow


def set_placement(panel: PanelDriver, placement: PointPlacement) -> None:
    panel.controller.state = replace(panel.state, placement=placement)


def test_placement_starts_and_ok_works_only_if_all_points_are_placed(
    open_panel: Callable[..., PanelDriver], points: np.ndarray
) -> None:
    panel = open_panel(draw_face)
    panel.press("Place points ...")
    assert panel.state.placement is not None and panel.state.placement.missing == 0
    panel.press("Cancel")
    assert panel.state.placement is None
    set_placement(panel, PointPlacement())
    panel.press("OK")
    assert panel.state.placement is not None
    set_placement(panel, PointPlacement(points + 0.1))
    panel.press("OK")
    assert panel.state.placement is None
    np.testing.assert_allclose(panel.controller.face.document.points, points + 0.1)


def test_left_points_are_mirrored_and_undone(open_panel: Callable[..., PanelDriver], points: np.ndarray) -> None:
    panel = open_panel(draw_face)
    placement = PointPlacement()
    for point in LEFT_POINTS:
        placement = placement.set_point(point, points[point])
    set_placement(panel, placement)
    panel.press("Left to right")
    assert panel.state.placement is not None
    assert panel.state.placement.missing == placement.missing - len(LEFT_POINTS)
    panel.press("Undo")
    assert panel.state.placement.missing == placement.missing


def test_a_face_without_points_offers_fitting_and_axes(
    open_panel: Callable[..., PanelDriver], unplaced_mesh: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    started: list[tuple[Path, Axes]] = []

    def fit(path: Path, axes: Axes, on_progress: Callable[[float, str], None]) -> FitResult:
        started.append((path, axes))
        return FitResult(np.ones((50, 3)))

    panel = open_panel(draw_face)
    panel.controller.open_file(unplaced_mesh, NOW)
    panel.controller.fitting = BackgroundFit(fit)
    panel.press("Find points")
    panel.controller.fitting.close()
    assert started == [(unplaced_mesh, (None, None))]
    offered: dict[str, Sequence[str]] = {}

    def choose(text: str, value: str, names: Sequence[str]) -> str:
        offered[text] = names
        return {"up axis": "z", "front axis": "x"}[text]

    monkeypatch.setattr(module, "combo_box", choose)
    panel.draw()
    assert panel.controller.face.document.axes == ("z", "x")
    assert "z" in offered["up axis"] and not {"z", "-z"} & set(offered["front axis"])
