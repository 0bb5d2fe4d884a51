"""Input events of a window.

Distances of drags are image heights, x right, y up, so that a drag has the same effect in a window of any size.
"""

from dataclasses import dataclass

from conf.render.camera import ViewState


@dataclass(frozen=True)
class KeyPressed:
    """A key was pressed: "space", "escape", "home", or the character of the key in lower case."""

    key: str


@dataclass(frozen=True)
class Dragged:
    """The mouse moved with a button held down. mode : "orbit" or "pan" """

    mode: str
    dx: float
    dy: float


@dataclass(frozen=True)
class Scrolled:
    """The mouse wheel moved; steps are positive away from the user."""

    steps: float


@dataclass(frozen=True)
class MouseMoved:
    """Position of the mouse: framebuffer pixels from the upper left corner, x right, y down."""

    x: float
    y: float


@dataclass(frozen=True)
class MouseButton:
    """A mouse button, 0 left, 1 right, 2 middle, was pressed or released; position as in MouseMoved."""

    button: int
    pressed: bool
    x: float
    y: float


@dataclass(frozen=True)
class KeyStateChanged:
    """One of EDITING_KEYS was pressed or released: what text fields need besides the text."""

    key: str
    pressed: bool


@dataclass(frozen=True)
class TextInput:
    """Text was typed."""

    text: str


@dataclass(frozen=True)
class FilesDropped:
    """Files were dropped onto the window."""

    paths: tuple[str, ...]


Event = KeyPressed | Dragged | Scrolled | MouseMoved | MouseButton | KeyStateChanged | TextInput | FilesDropped

# Names as in Dear ImGui.
EDITING_KEYS = (
    "left_ctrl", "right_ctrl", "left_shift", "right_shift", "left_alt", "right_alt", "backspace", "delete", "enter",
    "keypad_enter", "tab", "escape", "home", "end", "left_arrow", "right_arrow", "up_arrow", "down_arrow", "a", "c",
    "v", "x", "z",
)  # fmt: skip


def apply_camera_event(view: ViewState, event: Event) -> ViewState:
    """Return the view orbited or panned by a drag, or zoomed by the wheel; unchanged by other events."""
    match event:
        case Dragged(mode="orbit", dx=dx, dy=dy):
            return view.orbited(dx, dy)
        case Dragged(mode="pan", dx=dx, dy=dy):
            return view.panned(dx, dy)
        case Scrolled(steps=steps):
            return view.zoomed(steps)
        case _:
            return view
