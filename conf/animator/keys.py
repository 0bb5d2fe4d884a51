"""The keys of the animator's window: one table for the controller, the help and the texts that name a key."""

from conf.render.window.input_events import Event, KeyPressed, KeyStateChanged

# key -> (action, help text); keys with an empty help text share that of another key.
KEYS = {
    "space": ("play", "pause and resume, or repeat the emotion"),
    "left_arrow": ("step", "one frame back, one frame forward"),
    "right_arrow": ("step", ""),
    "w": ("wireframe", "wireframe"),
    "g": ("regions", "regions of influence"),
    "p": ("points", "control points"),
    "e": ("eye contact", "eye contact"),
    "s": ("screenshot", "save the current view as JPEG"),
    "r": ("record", "record the face as MP4, stop recording"),
    "f": ("full screen", "full screen"),
    "home": ("reset", "reset the camera"),
    "0": ("reset", ""),
    "ctrl+z": ("undo", "undo, while placing points"),
    "h": ("help", "this help"),
    "escape": ("back", "close the help, stop placing points, or quit"),
    "q": ("quit", "quit"),
}
KEY_LABELS = {
    "space": "Space", "left_arrow": "Left", "right_arrow": "Right", "home": "Home", "ctrl+z": "Ctrl+Z",
    "escape": "Escape",
}  # fmt: skip
_ARROWS = ("left_arrow", "right_arrow")


def key_of(event: Event, *, ctrl: bool) -> str | None:
    """Return the key of KEYS that an event presses, None for any other event. ctrl : whether Ctrl is held down"""
    match event:
        case KeyPressed(key=key):
            name = f"ctrl+{key}" if ctrl and f"ctrl+{key}" in KEYS else key
        case KeyStateChanged(key=key, pressed=True) if key in _ARROWS:
            name = key
        case _:
            return None
    return name if name in KEYS else None


def key_label(action: str) -> str:
    """Return the keys of an action as text, such as "Home, 0". Raises KeyError for an unknown action."""
    keys = [KEY_LABELS.get(key, key.upper()) for key, (name, _) in KEYS.items() if name == action]
    if not keys:
        raise KeyError(action)
    return ", ".join(keys)


def help_lines() -> list[tuple[str, str]]:
    """Return the keys of each action with its help text."""
    return [(key_label(action), text) for action, text in KEYS.values() if text]
