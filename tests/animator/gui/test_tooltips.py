"""Every control of every panel has a tooltip."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from imgui_bundle import imgui

from conf.animator.controller import Controller
from conf.animator.gui.main import LEFT, RIGHT
from conf.animator.gui.panels.timeline import draw_timeline
from conf.animator.gui.question import draw_question
from conf.animator.gui.tooltips import TOOLTIPS, tooltip_of
from conf.animator.gui.widgets import button
from conf.animator.state.editor import PRESETS, MuscleState, ViewSettings
from conf.animator.state.point_placement import PointPlacement
from conf.face.deformation.rbf import KERNELS
from conf.face.formats.dpc import MotionClip
from conf.render.window.input_events import MouseMoved
from tests.animator.conftest import NOW
from tests.support.imgui_stage import WIDGETS, Stage


def test_a_label_or_its_kind_has_the_text() -> None:
    assert tooltip_of("##seek").startswith("Time in the recording")
    assert tooltip_of("Open##DPC file") == TOOLTIPS["Open"]
    assert tooltip_of("joy", "emotion") == "Play joy once, or hold it until it is released."
    assert tooltip_of("12 lip corner puller", "action unit").startswith("Intensity of action unit 12 lip corner puller")
    assert tooltip_of("unknown") == ""
    assert set(KERNELS) < set(TOOLTIPS)


def test_a_tooltip_appears_where_the_mouse_rests(stage: Stage) -> None:
    shown: list[bool] = []

    def draw() -> None:
        button("loop")
        shown.append(imgui.begin_item_tooltip())
        if shown[-1]:
            imgui.end_tooltip()

    stage.feed(MouseMoved(300, 600), draw)
    for _ in range(60):
        stage.frame(draw)
    assert not any(shown)
    stage.feed(MouseMoved(20, 15), draw)
    for _ in range(60):
        stage.frame(draw)
    assert shown[-1]


def undescribed(stage: Stage, draw: Callable[[], object], monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """Draw two frames. Returns the labels of the widgets without a tooltip."""
    last, drawn, described = "", set[str](), set[str]()

    def recording(original: Callable[..., Any]) -> Callable[..., Any]:
        def record(label: str, *rest: Any, **more: Any) -> Any:
            nonlocal last
            last = label
            drawn.add(label)
            return original(label, *rest, **more)

        return record

    def begin() -> bool:
        described.add(last)
        return False

    with monkeypatch.context() as patch:
        for name in (*WIDGETS, "separator_text"):
            patch.setattr(imgui, name, recording(getattr(imgui, name)))
        patch.setattr(imgui, "begin_item_tooltip", begin)
        for _ in range(2):
            stage.frame(draw)
    assert drawn
    headings = {"deformation by", "kernel", "regions of influence", "contraction", "emotions", "action units", "style",
                "light and background", "direction", "influence", "export", "face", "control points",
                "place the control points", "Waters' muscles"}  # fmt: skip
    return drawn - described - headings


@pytest.mark.slow
def test_every_control_has_a_tooltip(stage: Stage, controller: Controller, monkeypatch: pytest.MonkeyPatch) -> None:
    for draw in (*LEFT.values(), *RIGHT.values()):
        assert undescribed(stage, partial(draw, controller, NOW), monkeypatch) == set()
    assert undescribed(stage, lambda: draw_timeline(controller, NOW, 1.0), monkeypatch) == set()
    controller.play_clip("a", MotionClip(10.0, "fapu", np.zeros((21, 50, 3), np.float32)), NOW)
    controller.toggle_recorder(NOW)
    assert undescribed(stage, lambda: draw_timeline(controller, NOW, 1.0), monkeypatch) == set()
    controller.state = replace(
        controller.state,
        view=ViewSettings(style="regions"),
        muscles=replace(MuscleState(symmetric=False), contractions=PRESETS["smile"][0]),
    )
    controller.export_progress = 0.5
    for draw in (*LEFT.values(), *RIGHT.values()):
        assert undescribed(stage, partial(draw, controller, NOW), monkeypatch) == set()
    for placement in (PointPlacement(), PointPlacement(np.zeros((50, 3)))):
        controller.state = replace(controller.state, placement=placement.push_undo())
        assert undescribed(stage, lambda: LEFT["Face"](controller, NOW), monkeypatch) == set()
        for question in ("quit", "cancel"):
            controller.state = replace(controller.state, question=question)
            assert undescribed(stage, lambda: draw_question(controller, (200, 300), 1.0), monkeypatch) == set()
