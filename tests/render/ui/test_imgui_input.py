from imgui_bundle import imgui

from conf.render.ui.imgui_input import dropped_files, is_typing
from conf.render.window.input_events import FilesDropped, KeyPressed, KeyStateChanged, TextInput
from tests.support.imgui_stage import Stage


def test_typed_text_arrives_completely_and_ctrl_a_selects_all(stage: Stage) -> None:
    text = ["old"]

    def draw() -> None:
        imgui.set_cursor_screen_pos(imgui.ImVec2(10, 10))
        text[0] = imgui.input_text("field", text[0])[1]

    stage.frame(draw)
    assert not is_typing()
    stage.click(60, 18, draw)
    assert is_typing()
    for key in ("left_ctrl", "a"):
        stage.feed(KeyStateChanged(key, True), draw)
    for key in ("a", "left_ctrl"):
        stage.feed(KeyStateChanged(key, False), draw)
    for letter in "/vaczx.dpc":
        stage.input.process_events([KeyStateChanged(letter, True)] if letter in "acvxz" else [])
        stage.input.process_events([TextInput(letter)])
    for _ in range(3):
        stage.frame(draw)
    assert text == ["/vaczx.dpc"]


def test_dropped_files_are_found_among_events() -> None:
    assert dropped_files([KeyPressed("w"), FilesDropped(("a", "b")), FilesDropped(("c",))]) == ["a", "b", "c"]
