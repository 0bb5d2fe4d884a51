import pytest
from imgui_bundle import imgui

from conf.animator.gui.widgets import amount_slider, buttons, combo_box
from tests.support.imgui_stage import Stage


def test_buttons_fill_rows_and_say_which_was_pressed(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    pressed: list[str] = []

    def draw() -> None:
        name = buttons(("one", "two", "three"), 2, "two")
        if name:
            pressed.append(name)

    stage.frame(draw)
    for name in ("three", "one"):
        stage.click(*stage.find(name, draw, monkeypatch), draw)
    assert pressed == ["three", "one"]
    one, two, three = (stage.find(name, draw, monkeypatch) for name in ("one", "two", "three"))
    assert one[1] == two[1] < three[1] and one[0] == three[0] < two[0]


def test_what_is_not_touched_keeps_its_value(stage: Stage) -> None:
    values: list[object] = []
    stage.frame(lambda: values.extend([amount_slider("a", 3.0), combo_box("b", "y", ["x", "y"])]))
    assert values == [3.0, "y"]
    assert imgui.get_current_context() is not None
