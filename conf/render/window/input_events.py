"""What the viewer does with keyboard and mouse, and what each thing means.

Lengths are picture heights, x right, y up, so that a drag means the same in every window.
"""

from dataclasses import dataclass

from conf.render.camera import TOGGLES, ViewState


@dataclass(frozen=True)
class KeyPressed:
    """A key went down: its name as in KEYS, "space", "w", "escape"."""

    key: str


@dataclass(frozen=True)
class Dragged:
    """The mouse moved with a button held: "turn" or "pan"."""

    mode: str
    dx: float
    dy: float


@dataclass(frozen=True)
class Scrolled:
    """The wheel turned; steps are positive away from the viewer."""

    steps: float


@dataclass(frozen=True)
class Resized:
    """The framebuffer has a new size in pixels."""

    width: int
    height: int


@dataclass(frozen=True)
class MouseMoved:
    """The mouse is at a place: framebuffer pixels from the upper left corner, x right, y down."""

    x: float
    y: float


@dataclass(frozen=True)
class MouseButton:
    """A button of the mouse, 0 left, 1 right, 2 middle, went down or up at a place, pixels as in MouseMoved."""

    button: int
    pressed: bool
    x: float
    y: float


@dataclass(frozen=True)
class KeyStateChanged:
    """A key of EDITING_KEYS went down or up: what text fields live on beside the text."""

    key: str
    pressed: bool


@dataclass(frozen=True)
class TextInput:
    """Text came from the keyboard."""

    text: str


@dataclass(frozen=True)
class FilesDropped:
    """Files were dropped onto the window."""

    paths: tuple[str, ...]


Event = (
    KeyPressed | Dragged | Scrolled | Resized | MouseMoved | MouseButton | KeyStateChanged | TextInput | FilesDropped
)

# Names as Dear ImGui has them.
EDITING_KEYS = (
    "left_ctrl", "right_ctrl", "left_shift", "right_shift", "left_alt", "right_alt", "backspace", "delete", "enter",
    "keypad_enter", "tab", "escape", "home", "end", "left_arrow", "right_arrow", "up_arrow", "down_arrow", "a", "c",
    "v", "x", "z",
)  # fmt: skip

# key -> (action, what the help says). Toggles of the view carry the toggle's name.
KEYS = {
    "space": ("pause", "pause and go on"),
    "w": ("wireframe", "wireframe"),
    "p": ("points", "control points"),
    "m": ("meter", "meter"),
    "v": ("portrait", "the caller's own picture, or the head"),
    "c": ("centred", "centre the head, or as sent"),
    "s": ("picture", "save a picture (JPG)"),
    "r": ("record", "record a clip (AVI), stop recording"),
    "d": ("record motion", "record the motion (DPC), stop recording"),
    "1": ("emotion", "an emotion over the live motion"),
    **dict.fromkeys("23456", ("emotion", "")),
    "f": ("full screen", "full screen"),
    "h": ("help", "this help"),
    "home": ("reset", "look straight again"),
    "0": ("reset", ""),
    "escape": ("quit", "quit"),
    "q": ("quit", ""),
}
MOUSE = (("drag", "turn the head"), ("wheel", "zoom"), ("shift + drag", "move"))


def action_of(event: Event) -> str | None:
    """Return what a key asks for, None for other keys and events."""
    return KEYS.get(event.key, (None, ""))[0] if isinstance(event, KeyPressed) else None


def apply_camera_event(view: ViewState, event: Event) -> ViewState:
    """Return the view after an event: turned, zoomed, moved, toggled, or the same."""
    match event:
        case Dragged(mode="turn", dx=dx, dy=dy):
            return view.turned(dx, dy)
        case Dragged(mode="pan", dx=dx, dy=dy):
            return view.panned(dx, dy)
        case Scrolled(steps=steps):
            return view.zoomed(steps)
        case KeyPressed():
            action = action_of(event)
            if action in TOGGLES:
                return view.toggled(str(action))
            return view.reset() if action == "reset" else view
        case _:
            return view
