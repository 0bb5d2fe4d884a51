"""The buttons of a call, drawn over its image."""

from collections.abc import Sequence
from dataclasses import dataclass

from imgui_bundle import imgui

from conf.call.controls import BUTTONS, CALL_KEYS, LocalState
from conf.receiver.panel_layout import Rect
from conf.receiver.viewer_controls import key_label
from conf.render.ui.hud import RECORDING, Size
from conf.render.ui.imgui_overlay import MUTED, TEXT, ImGuiOverlay, panel
from conf.render.ui.theme import AMBER, HOVERED, RAISED

Colour = tuple[float, float, float, float]

# Pixels at scale 1.
PADDING = 12.0  # beside the text
HEIGHT = 30.0
GAP = 6.0
KEY_GAP = 8.0  # between a text and its key
ROUNDING = 8.0
DARK = (0.10, 0.07, 0.02, 1.0)
HANG_UP = (0.74, 0.16, 0.14, 0.95)
HANG_UP_HOVERED = (0.86, 0.22, 0.19, 1.0)
OPACITY = 0.92

KEY_OF = {action: key for key, (action, text) in CALL_KEYS.items() if text}


@dataclass(frozen=True)
class Button:
    """A button. is_warning : drawn in amber, as something is off that usually is on"""

    action: str
    text: str
    key: str
    is_warning: bool = False
    is_active: bool = False


def buttons_of(state: LocalState, *, is_recording: bool, in_call: bool) -> list[Button]:
    """Return the buttons, each with its key."""
    texts = {
        "microphone": "no microphone" if not state.has_microphone else "mute" if state.microphone else "muted",
        "camera": "camera is off" if not state.camera else "no camera" if state.camera_fault else "camera off",
        "own portrait": "portrait is on" if state.portrait else "portrait on",
        "record video": "stop recording" if is_recording else "record",
        "quit": "hang up" if in_call else "leave",
    }
    warnings = {"microphone": not (state.microphone and state.has_microphone), "camera": not state.shows_face}
    active = {"own portrait": state.portrait, "record video": is_recording}
    return [
        Button(
            action,
            texts[action],
            key_label(KEY_OF[action]),
            is_warning=warnings.get(action, False),
            is_active=active.get(action, False),
        )
        for action in BUTTONS
    ]


def button_size(button: Button, scale: float) -> Size:
    """Return the size of a button. Call it inside `overlay.frame`."""
    width = imgui.calc_text_size(button.text).x + 2 * PADDING * scale
    if button.key:
        width += imgui.calc_text_size(button.key).x + KEY_GAP * scale
    return width, HEIGHT * scale


def toolbar_sizes(buttons: Sequence[Button], scale: float) -> tuple[Size, list[Size]]:
    """Return the size of the whole row and of each button."""
    sizes = [button_size(button, scale) for button in buttons]
    return (sum(width for width, _ in sizes) + GAP * scale * (len(sizes) - 1), HEIGHT * scale), sizes


def lay_out_buttons(rect: Rect, sizes: Sequence[Size], scale: float) -> list[Rect]:
    """Return the rectangles of the buttons in their row."""
    places, left = [], rect.left
    for width, height in sizes:
        places.append(Rect(left, rect.top, width, height))
        left += width + GAP * scale
    return places


def draw_toolbar(
    overlay: ImGuiOverlay, buttons: Sequence[Button], places: Sequence[Rect], *, hovered: str | None
) -> None:
    """Draw the buttons. Call it inside `overlay.frame`. hovered : the action of the button under the mouse"""
    scale = overlay.scale
    left, top = places[0].left, places[0].top
    padding = imgui.get_style().window_padding
    width, height = places[-1].right - left, places[0].height
    imgui.set_next_window_bg_alpha(0.0)
    with panel("toolbar", (left - padding.x, top - padding.y), (0.0, 0.0), (width, height)):
        draw = imgui.get_window_draw_list()
        for button, place in zip(buttons, places, strict=True):
            background, foreground = _colours(button, is_hovered=button.action == hovered)
            corners = imgui.ImVec2(place.left, place.top), imgui.ImVec2(place.right, place.bottom)
            draw.add_rect_filled(*corners, _u32(background), ROUNDING * scale)
            y = place.top + (place.height - imgui.get_text_line_height()) / 2
            x = place.left + PADDING * scale
            draw.add_text(imgui.ImVec2(x, y), _u32(foreground), button.text)
            if button.key:
                x = place.right - PADDING * scale - imgui.calc_text_size(button.key).x
                draw.add_text(imgui.ImVec2(x, y), _u32((*foreground[:3], 0.62)), button.key)


def _colours(button: Button, *, is_hovered: bool) -> tuple[Colour, Colour]:
    """Return the colours of background and text."""
    if button.action == "quit":
        return (HANG_UP_HOVERED if is_hovered else HANG_UP), TEXT
    if button.is_warning:
        return AMBER, DARK
    background = (*(HOVERED if is_hovered else RAISED)[:3], OPACITY)
    if button.is_active:
        return background, RECORDING if button.action == "record video" else TEXT
    return background, TEXT if is_hovered else MUTED


def _u32(colour: Colour) -> int:
    return int(imgui.get_color_u32(imgui.ImVec4(*colour)))
