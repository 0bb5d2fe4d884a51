from imgui_bundle import imgui

from conf.animator.gui.theme import CHOSEN, column
from tests.support.imgui_stage import Stage


def test_the_look_is_there_inside_and_gone_outside(stage: Stage) -> None:
    seen: list[float] = []
    before = imgui.get_style().frame_rounding

    def draw() -> None:
        seen.append(imgui.get_style().frame_rounding)
        seen.append(imgui.get_style().color_(imgui.Col_.header).x)
        seen.append(imgui.get_window_width())

    stage.frame(draw)
    assert seen[0] == 3.0 and abs(seen[1] - CHOSEN[0]) < 1e-6 and seen[2] == stage.rect.width
    assert imgui.get_style().frame_rounding == before
    assert column is not None
