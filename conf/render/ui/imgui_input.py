"""Dear ImGui's input backend, and queries for what remains for the program."""

from collections.abc import Iterable

from imgui_bundle import imgui

from conf.render.window import input_events

MODIFIERS = {"ctrl": imgui.Key.mod_ctrl, "shift": imgui.Key.mod_shift, "alt": imgui.Key.mod_alt}


class ImGuiInput:
    """Forwards window events to Dear ImGui's IO."""

    def __init__(self) -> None:
        self._ctrl = False

    def process_events(self, events: Iterable[input_events.Event]) -> None:
        """Forward the events since ImGui's last frame."""
        io = imgui.get_io()
        for event in events:
            match event:
                case input_events.MouseMoved(x=x, y=y):
                    io.add_mouse_pos_event(x, y)
                case input_events.MouseButton(button=button, pressed=pressed, x=x, y=y) if button < 3:
                    io.add_mouse_pos_event(x, y)
                    io.add_mouse_button_event(button, pressed)
                case input_events.Scrolled(steps=steps):
                    io.add_mouse_wheel_event(0.0, steps)
                case input_events.KeyStateChanged(key=key, pressed=pressed):
                    self._set_key(io, key, pressed)
                case input_events.TextInput(text=text):
                    io.add_input_characters_utf8(text)
                case _:
                    pass

    def _set_key(self, io: imgui.IO, key: str, pressed: bool) -> None:
        modifier = key.rpartition("_")[2]
        if modifier == "ctrl":
            self._ctrl = pressed
        # ImGui processes a key and a character in separate frames: with letter keys, one letter per frame would arrive.
        if len(key) == 1 and pressed and not self._ctrl:
            return
        if modifier in MODIFIERS:
            io.add_key_event(MODIFIERS[modifier], pressed)
        io.add_key_event(getattr(imgui.Key, key), pressed)


def is_typing() -> bool:
    """Tell whether a text field has the keyboard focus."""
    return bool(imgui.get_io().want_text_input)


def dropped_files(events: Iterable[input_events.Event]) -> list[str]:
    """Return the paths of files dropped onto the window."""
    return [path for event in events if isinstance(event, input_events.FilesDropped) for path in event.paths]
