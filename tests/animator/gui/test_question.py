from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from conf.animator.controller import Controller
from conf.animator.gui.question import DISCARD, DISCARD_POINTS, KEEP, KEEP_POINTS, SAVE, draw_question
from conf.animator.state.point_placement import PointPlacement
from conf.face.formats.ppc import read_ppc
from tests.support.imgui_stage import Stage

pytestmark = pytest.mark.slow


class Asked:
    """A question that is drawn; presses its buttons."""

    def __init__(self, stage: Stage, controller: Controller, monkeypatch: pytest.MonkeyPatch) -> None:
        self._stage, self._controller, self._monkeypatch = stage, controller, monkeypatch
        self.decided = False
        for _ in range(2):
            stage.frame(self.draw)

    def draw(self) -> None:
        self.decided |= draw_question(self._controller, (200, 300), 1.0)

    def labels(self) -> set[str]:
        return set(self._stage.widgets(self.draw, self._monkeypatch))

    def press(self, label: str) -> None:
        self._stage.click(*self._stage.find(label, self.draw, self._monkeypatch), self.draw)


@pytest.fixture
def ask(stage: Stage, controller: Controller, monkeypatch: pytest.MonkeyPatch) -> Callable[[], Asked]:
    return lambda: Asked(stage, controller, monkeypatch)


def place(controller: Controller, points: np.ndarray) -> None:
    controller.state = replace(controller.state, placement=PointPlacement(points).push_undo())


def test_missing_points_can_be_discarded_or_kept(ask: Callable[[], Asked], controller: Controller) -> None:
    place(controller, np.full((50, 3), np.nan))
    assert not controller.request_quit() and controller.state.question == "quit"
    question = ask()
    assert question.labels() == {DISCARD, KEEP}
    question.press(KEEP)
    assert controller.state.question is None and not question.decided and question.labels() == set()
    assert not controller.request_quit()
    question = ask()
    question.press(DISCARD)
    assert question.decided and controller.request_quit()


def test_placed_points_are_saved_before_quitting(
    ask: Callable[[], Asked], controller: Controller, points: np.ndarray, tmp_path: Path
) -> None:
    fields = replace(controller.state.fields, points=str(tmp_path / "a.ppc"))
    controller.state = replace(controller.state, fields=fields)
    place(controller, points + 0.1)
    assert not controller.request_quit()
    question = ask()
    question.press(SAVE)
    assert question.decided and controller.request_quit()
    np.testing.assert_allclose(read_ppc(tmp_path / "a.ppc"), points + 0.1, atol=1e-4)


def test_points_that_cannot_be_saved_keep_the_window_open(
    ask: Callable[[], Asked], controller: Controller, points: np.ndarray, tmp_path: Path
) -> None:
    fields = replace(controller.state.fields, points=str(tmp_path / "no" / "folder.ppc"))
    controller.state = replace(controller.state, fields=fields)
    place(controller, points + 0.1)
    controller.request_quit()
    question = ask()
    question.press(SAVE)
    assert not question.decided and controller.state.question is None
    assert "cannot be written" in controller.notice and controller.has_unsaved_points


def test_cancelling_asks_only_if_points_would_be_lost(ask: Callable[[], Asked], controller: Controller) -> None:
    controller.state = replace(controller.state, placement=PointPlacement())
    controller.cancel_placement()
    assert controller.state.placement is None and controller.state.question is None
    place(controller, np.full((50, 3), np.nan))
    controller.cancel_placement()
    assert controller.state.question == "cancel"
    ask().press(KEEP_POINTS)
    assert controller.state.placement is not None and controller.state.question is None
    controller.cancel_placement()
    ask().press(DISCARD_POINTS)
    assert controller.state.placement is None and controller.state.question is None
