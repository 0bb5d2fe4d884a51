import pytest

from conf.animator.gui.widgets import buttons, combo_box, slider
from tests.support.imgui_stage import Stage


def test_buttons_fill_rows_and_return_the_one_pressed(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_a_value_outside_the_limits_is_kept_until_the_user_changes_it(
    stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    values: list[float] = []

    def draw() -> None:
        values.append(slider("a", 3.0, (0.0, 1.0)))

    stage.frame(draw)
    assert values[-1] == 3.0
    stage.click(*stage.find("##a", draw, monkeypatch), draw)
    assert min(values) == pytest.approx(0.5, abs=0.05)


def test_a_list_returns_its_value_or_the_first_name(stage: Stage) -> None:
    values: list[str] = []
    stage.frame(lambda: values.extend([combo_box("a", "y", ["x", "y"]), combo_box("b", "z", ["x", "y"])]))
    assert values == ["y", "x"]
