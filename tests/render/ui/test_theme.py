from imgui_bundle import imgui

from conf.render.ui.theme import SELECTED, column, themed
from tests.support.imgui_stage import Stage


def test_the_theme_applies_inside_only(stage: Stage) -> None:
    values: list[float] = []
    before = imgui.get_style().frame_rounding

    def draw() -> None:
        values.append(imgui.get_style().frame_rounding)
        with themed(2.0):
            values.append(imgui.get_style().frame_rounding)
        values.append(imgui.get_style().color_(imgui.Col_.header).x)

    stage.frame(draw)
    assert values[:2] == [3.0, 6.0] and abs(values[2] - SELECTED[0]) < 1e-6
    assert imgui.get_style().frame_rounding == before


def test_a_column_fills_its_rectangle(stage: Stage) -> None:
    sizes: list[tuple[float, float]] = []

    def draw() -> None:
        with column("inner", stage.rect):
            sizes.append((imgui.get_window_width(), imgui.get_window_height()))

    stage.frame(draw)
    assert sizes == [(stage.rect.width, stage.rect.height)]
