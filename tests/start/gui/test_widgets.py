"""Rows, buttons and bars: what they return and draw."""

import numpy as np
import pytest
from imgui_bundle import imgui

from conf.render.ui.theme import AMBER, GREEN
from conf.render.window.input_events import KeyStateChanged, TextInput
from conf.start.devices.choices import Choice
from conf.start.gui.widgets import FieldInput, button, checkbox, combo_box, level_bar, row_button, shortened, text_field
from tests.support.imgui_stage import Stage

CHOICES = [Choice("the first", None), Choice("0: one", "0"), Choice("2: two", "2")]


def test_a_field_tells_typing_enter_and_leaving(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    inputs: list[FieldInput] = []

    def draw() -> None:
        inputs.append(text_field("address", inputs[-1].text if inputs else "", hint="HOST", error="no"))

    stage.frame(draw)
    stage.click(*stage.find("##address", draw, monkeypatch), draw)
    stage.feed(TextInput("h"), draw)
    stage.frame(draw)
    assert inputs[-1] == FieldInput("h", entered=False, left=False)
    stage.feed(KeyStateChanged("enter", True), draw)
    assert any(field.entered for field in inputs) and any(field.left for field in inputs)


@pytest.mark.parametrize(("setting", "expected"), [(None, None), ("0", "0"), ("2", "2")])
def test_a_list_shows_the_row_of_its_setting(stage: Stage, setting: str | None, expected: str | None) -> None:
    values: list[str | None] = []
    stage.frame(lambda: values.append(combo_box("camera", CHOICES, setting)))
    assert values == [expected]


def test_buttons_and_check_boxes_are_clicked(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    pressed: list[str] = []
    values = [False]

    def draw() -> None:
        if button("Call", -1, is_main=True):
            pressed.append("Call")
        if row_button("Anna", "12:00", "call 0", "recent call"):
            pressed.append("Anna")
        values.append(checkbox("portrait", "send photos", values[-1]))

    stage.frame(draw)
    for name in ("Call", "##call 0", "send photos##portrait"):
        stage.click(*stage.find(name, draw, monkeypatch), draw)
    assert pressed == ["Call", "Anna"] and values[-1]


@pytest.mark.parametrize("level", [0.0, 0.5, 1.0])
def test_a_bar_is_as_long_as_the_level_and_warns_of_clipping(stage: Stage, level: float) -> None:
    stage.frame(lambda: level_bar(level))
    pixels = stage.window.read()[:, :, ::-1].astype(int)

    def columns(colour: tuple[float, float, float, float]) -> int:
        near = np.abs(pixels - np.array(colour[:3]) * 255).max(axis=2) < 8
        return int(near.any(axis=0).sum())

    width = stage.rect.width - 20
    assert columns(GREEN) == pytest.approx(min(level, 0.85) * width, abs=2)
    assert columns(AMBER) == pytest.approx(max(0.0, level - 0.85) * width, abs=2)


def test_long_texts_are_shortened(stage: Stage) -> None:
    texts: list[str] = []
    stage.frame(lambda: texts.extend([shortened("a" * 100, 100.0), shortened("abc", 100.0), shortened("abc", 1.0)]))
    assert texts[0].endswith("a...") and len(texts[0]) < 30 and texts[1:] == ["abc", "..."]
    widths: list[float] = []
    stage.frame(lambda: widths.append(imgui.calc_text_size(texts[0]).x))
    assert widths[0] <= 100
