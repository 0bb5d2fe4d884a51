"""Bring what keyboard and mouse do to Dear ImGui, and find out what is left for the face."""

from collections.abc import Iterable

from imgui_bundle import imgui

from conf.render.window.input_events import (
    Event,
    FilesDropped,
    KeyStateChanged,
    MouseButton,
    MouseMoved,
    Scrolled,
    TextInput,
)

MODIFIERS = {"ctrl": imgui.Key.mod_ctrl, "shift": imgui.Key.mod_shift, "alt": imgui.Key.mod_alt}


class ImGuiInput:
    """Tells ImGui what keyboard and mouse do."""

    def __init__(self) -> None:
        self._ctrl = False

    def process_events(self, events: Iterable[Event]) -> None:
        """Tell ImGui what happened since its last frame."""
        io = imgui.get_io()
        for event in events:
            match event:
                case MouseMoved(x=x, y=y):
                    io.add_mouse_pos_event(x, y)
                case MouseButton(button=button, pressed=pressed, x=x, y=y) if button < 3:
                    io.add_mouse_pos_event(x, y)
                    io.add_mouse_button_event(button, pressed)
                case Scrolled(steps=steps):
                    io.add_mouse_wheel_event(0.0, steps)
                case KeyStateChanged(key=key, pressed=pressed):
                    self._hold(io, key, pressed)
                case TextInput(text=text):
                    io.add_input_characters_utf8(text)
                case _:
                    pass

    def _hold(self, io: imgui.IO, key: str, pressed: bool) -> None:
        modifier = key.rpartition("_")[2]
        if modifier == "ctrl":
            self._ctrl = pressed
        # ImGui takes a key and a character in frames of their own: what is typed would come one letter a frame.
        if len(key) == 1 and pressed and not self._ctrl:
            return
        if modifier in MODIFIERS:
            io.add_key_event(MODIFIERS[modifier], pressed)
        io.add_key_event(getattr(imgui.Key, key), pressed)


def is_typing() -> bool:
    """Tell whether a text field has the keyboard."""
    return bool(imgui.get_io().want_text_input)


def dropped_files(events: Iterable[Event]) -> list[str]:
    """Return the paths of files dropped onto the window."""
    return [path for event in events if isinstance(event, FilesDropped) for path in event.paths]
