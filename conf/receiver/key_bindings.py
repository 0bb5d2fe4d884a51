"""Keys of the receiver's window and their actions."""

from conf.render.camera import TOGGLES, ViewState
from conf.render.window.input_events import Event, KeyPressed, apply_camera_event

# key -> (action, help text); keys with an empty help text share that of another key. Actions that are the name of a
# switch of ViewState toggle it.
KEYS = {
    "space": ("pause", "pause and go on"),
    "w": ("wireframe", "wireframe"),
    "p": ("points", "control points"),
    "m": ("stats", "call statistics"),
    "v": ("portrait", "the caller's own picture, or the head"),
    "c": ("centred", "centre the head, or as sent"),
    "s": ("save image", "save a picture (JPG)"),
    "r": ("record video", "record a clip (AVI), stop recording"),
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
MOUSE_HELP = (("drag", "turn the head"), ("wheel", "zoom"), ("shift + drag", "move"))
KEY_LABELS = {"space": "Space", "home": "Home", "escape": "Esc"}


def action_of(event: Event) -> str | None:
    """Return the action of a key, None for other keys and events."""
    return KEYS.get(event.key, (None, ""))[0] if isinstance(event, KeyPressed) else None


def apply_view_event(view: ViewState, event: Event) -> ViewState:
    """Return the view changed by a key or the mouse; unchanged by other events."""
    action = action_of(event)
    if action in TOGGLES:
        return view.toggled(str(action))
    return view.reset() if action == "reset" else apply_camera_event(view, event)


def help_lines() -> list[tuple[str, str]]:
    """Return keys and mouse gestures with their help texts; keys with the same action are on one line."""
    keys: dict[str, list[str]] = {}
    for key, (action, _) in KEYS.items():
        keys.setdefault(action, []).append(KEY_LABELS.get(key, key.upper()))
    texts = {action: text for action, text in KEYS.values() if text}
    return [(", ".join(keys[action]), text) for action, text in texts.items()] + list(MOUSE_HELP)
