import pytest

from conf.animator.keys import KEYS, help_lines, key_label, key_of
from conf.render.window.input_events import KeyPressed, KeyStateChanged, MouseMoved


def test_every_key_is_listed_once_with_its_help_text() -> None:
    listed = ", ".join(keys for keys, _ in help_lines()).split(", ")
    assert len(listed) == len(set(listed)) == len(KEYS)
    assert dict(help_lines())["Home, 0"] == "reset the camera"
    assert dict(help_lines())["Left, Right"] == "one frame back, one frame forward"
    assert len({action for action, text in KEYS.values() if text}) == len(help_lines()) == len(dict(help_lines()))


def test_events_name_the_keys_of_the_table() -> None:
    assert key_of(KeyPressed("w"), ctrl=False) == "w"
    assert key_of(KeyPressed("z"), ctrl=False) is None
    assert key_of(KeyPressed("z"), ctrl=True) == "ctrl+z"
    assert key_of(KeyPressed("q"), ctrl=True) == "q", "Ctrl+Q quits as in other programs"
    assert key_of(KeyStateChanged("left_arrow", True), ctrl=False) == "left_arrow"
    assert key_of(KeyStateChanged("left_arrow", False), ctrl=False) is None
    assert key_of(KeyStateChanged("escape", True), ctrl=False) is None, "escape arrives as a pressed key too"
    assert key_of(MouseMoved(1.0, 2.0), ctrl=False) is None


def test_texts_name_keys_by_their_action() -> None:
    assert key_label("record") == "R" and key_label("undo") == "Ctrl+Z" and key_label("play") == "Space"
    with pytest.raises(KeyError, match="dance"):
        key_label("dance")
