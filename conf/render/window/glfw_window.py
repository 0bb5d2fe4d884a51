"""A window on the screen: GLFW with an OpenGL 3.3 context, and what the viewer does in it as events."""

import os
from collections.abc import Callable
from types import TracebackType
from typing import Any

import glfw
import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.errors import GraphicsError
from conf.render.window.input_events import (
    EDITING_KEYS,
    KEYS,
    Dragged,
    Event,
    FilesDropped,
    KeyPressed,
    KeyStateChanged,
    MouseButton,
    MouseMoved,
    Resized,
    Scrolled,
    TextInput,
)
from conf.render.window.offscreen import BLACK, Colour, read_pixels

NO_DISPLAY = (
    "no window can be opened: there is no display (DISPLAY is {display}); "
    "run in a desktop session, or draw without a window with --headless OUT.avi"
)
NO_OPENGL = (
    "the display has no OpenGL 3.3: install a driver with `sudo apt install libgl1 libgl1-mesa-dri`, "
    "or draw without a window with --headless OUT.avi"
)

CONTEXT_HINTS = (
    (glfw.CONTEXT_VERSION_MAJOR, 3),
    (glfw.CONTEXT_VERSION_MINOR, 3),
    (glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE),
    (glfw.OPENGL_FORWARD_COMPAT, True),
    (glfw.SCALE_TO_MONITOR, True),
    (glfw.DEPTH_BITS, 24),
)
NAMED_KEYS = {
    glfw.KEY_SPACE: "space",
    glfw.KEY_ESCAPE: "escape",
    glfw.KEY_HOME: "home",
    glfw.KEY_KP_0: "0",
    glfw.KEY_0: "0",
}
_GLFW_NAMES = {"_ctrl": "_control", "keypad_": "kp_", "_arrow": ""}


def _glfw_key(name: str) -> int:
    """Return GLFW's number of one of EDITING_KEYS."""
    for ours, theirs in _GLFW_NAMES.items():
        name = name.replace(ours, theirs)
    return int(getattr(glfw, f"KEY_{name.upper()}"))


HELD_KEYS = {_glfw_key(name): name for name in EDITING_KEYS}
MIN_SIZE = 64  # pixels a side: a window cannot be made smaller


class _GlfwContextLoader:
    """Finds OpenGL's functions through GLFW, which knows whether this is X11, Wayland, Windows or macOS."""

    def load_opengl_function(self, name: str) -> int:
        return int(glfw.get_proc_address(name) or 0)

    def __enter__(self) -> "_GlfwContextLoader":
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def release(self) -> None:
        """Leave the context alone: it belongs to the window."""


class GlfwWindow:
    """A window with the interface of `OffscreenWindow`. Close it, or press Escape: `should_close` becomes true."""

    def __init__(self, width: int, height: int, title: str) -> None:
        if width < 1 or height < 1:
            raise ValueError(f"width and height must be positive, got {width} x {height}")
        glfw.ERROR_REPORTING = "ignore"
        if not glfw.init():
            raise GraphicsError(NO_DISPLAY.format(display=os.environ.get("DISPLAY") or "not set"))
        for hint, value in CONTEXT_HINTS:
            glfw.window_hint(hint, value)
        self._window = glfw.create_window(width, height, title, None, None)
        if not self._window:
            glfw.terminate()
            raise GraphicsError(NO_OPENGL)
        glfw.make_context_current(self._window)
        glfw.swap_interval(1)
        glfw.set_window_size_limits(self._window, MIN_SIZE, MIN_SIZE, glfw.DONT_CARE, glfw.DONT_CARE)
        found_by_glfw: dict[str, Any] = {"context": _GlfwContextLoader()}
        self.ctx = moderngl.create_context(require=330, **found_by_glfw)
        self.framebuffer = self.ctx.screen
        self.size = self._measure()  # of the framebuffer: more than the window's points on a HiDPI display
        self.close_on_escape = True  # whether Escape and Q close the window; a program with text fields decides itself
        self._events: list[Event] = []
        self._cursor = glfw.get_cursor_pos(self._window)
        self._before_full_screen: tuple[int, int, int, int] | None = None
        self._listen()

    @property
    def pixel_ratio(self) -> float:
        """Pixels a point of the display."""
        return float(glfw.get_window_content_scale(self._window)[0])

    @property
    def should_close(self) -> bool:
        """Whether the viewer wants to go."""
        return bool(glfw.window_should_close(self._window))

    @should_close.setter
    def should_close(self, value: bool) -> None:
        glfw.set_window_should_close(self._window, value)

    def poll(self) -> list[Event]:
        """Return what the viewer did since the last call, oldest first."""
        glfw.poll_events()
        events, self._events = self._events, []
        return events

    def begin(self, colour: Colour = BLACK) -> None:
        """Start a frame: of one colour, as large as the window is now, and drawn into from now on."""
        glfw.make_context_current(self._window)
        self.size = self._measure()
        self.framebuffer.viewport = (0, 0, *self.size)
        self.framebuffer.use()
        self.framebuffer.clear(*colour)

    def end(self) -> None:
        """Present the frame; waits for the display's next refresh where there is one."""
        glfw.swap_buffers(self._window)

    def read(self) -> NDArray[np.uint8]:
        """Return the picture as (H, W, 3) uint8 BGR. To be called before `end`."""
        return read_pixels(self.framebuffer, self.size)

    def toggle_full_screen(self) -> None:
        """Fill the monitor, or go back to where the window was."""
        if self._before_full_screen is None:
            self._before_full_screen = (*glfw.get_window_pos(self._window), *glfw.get_window_size(self._window))
            monitor = glfw.get_primary_monitor()
            if monitor:
                mode = glfw.get_video_mode(monitor)
                glfw.set_window_monitor(self._window, monitor, 0, 0, *mode.size, mode.refresh_rate)
        else:
            glfw.set_window_monitor(self._window, None, *self._before_full_screen, glfw.DONT_CARE)  # type: ignore[arg-type]
            self._before_full_screen = None

    def release(self) -> None:
        """Close the window; it cannot be used any more."""
        self.ctx.release()
        glfw.destroy_window(self._window)
        glfw.terminate()

    def __enter__(self) -> "GlfwWindow":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.release()

    def _measure(self) -> tuple[int, int]:
        width, height = glfw.get_framebuffer_size(self._window)
        return max(1, width), max(1, height)

    def _listen(self) -> None:
        listeners: tuple[tuple[Callable[..., Any], Callable[..., None]], ...] = (
            (glfw.set_key_callback, self._on_key),
            (glfw.set_cursor_pos_callback, self._on_cursor),
            (glfw.set_scroll_callback, self._on_scroll),
            (glfw.set_framebuffer_size_callback, self._on_resize),
            (glfw.set_mouse_button_callback, self._on_button),
            (glfw.set_char_callback, self._on_text),
            (glfw.set_drop_callback, self._on_drop),
        )
        for register, listener in listeners:
            register(self._window, listener)

    def _on_key(self, _window: object, key: int, scancode: int, action: int, _mods: int) -> None:
        if key in HELD_KEYS and action != glfw.REPEAT:
            self._events.append(KeyStateChanged(HELD_KEYS[key], action == glfw.PRESS))
        if action != glfw.PRESS:
            return
        name = NAMED_KEYS.get(key) or (glfw.get_key_name(key, scancode) or "").lower()
        if name:
            self._events.append(KeyPressed(name))
        if self.close_on_escape and KEYS.get(name, ("", ""))[0] == "quit":
            self.should_close = True

    def _on_cursor(self, _window: object, x: float, y: float) -> None:
        dx, dy = x - self._cursor[0], y - self._cursor[1]
        self._cursor = (x, y)
        self._events.append(MouseMoved(*self._pixels(x, y)))
        purpose = self._purpose_of_drag()
        if purpose:
            height = max(1, glfw.get_window_size(self._window)[1])
            self._events.append(Dragged(purpose, dx / height, -dy / height))

    def _purpose_of_drag(self) -> str | None:
        def held(button: int) -> bool:
            return bool(glfw.get_mouse_button(self._window, button) == glfw.PRESS)

        if held(glfw.MOUSE_BUTTON_LEFT):
            shift = (glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SHIFT)
            return "pan" if any(glfw.get_key(self._window, key) == glfw.PRESS for key in shift) else "turn"
        return "pan" if held(glfw.MOUSE_BUTTON_MIDDLE) else None

    def _on_button(self, _window: object, button: int, action: int, _mods: int) -> None:
        place = self._pixels(*glfw.get_cursor_pos(self._window))
        self._events.append(MouseButton(button, action == glfw.PRESS, *place))

    def _on_text(self, _window: object, codepoint: int) -> None:
        self._events.append(TextInput(chr(codepoint)))

    def _on_drop(self, _window: object, paths: list[str]) -> None:
        self._events.append(FilesDropped(tuple(paths)))

    def _pixels(self, x: float, y: float) -> tuple[float, float]:
        """Return a place of the window, in its points, as framebuffer pixels."""
        ratio = self.size[0] / max(1, glfw.get_window_size(self._window)[0])
        return x * ratio, y * ratio

    def _on_scroll(self, _window: object, _dx: float, dy: float) -> None:
        self._events.append(Scrolled(dy))

    def _on_resize(self, _window: object, width: int, height: int) -> None:
        self._events.append(Resized(max(1, width), max(1, height)))
