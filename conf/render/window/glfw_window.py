"""A window on a display: GLFW with an OpenGL 3.3 context, and its input as events."""

import os
from collections.abc import Callable
from typing import Any

import glfw
import moderngl

from conf.errors import GraphicsError
from conf.render.gpu_object import GpuObject
from conf.render.window import BLACK, Colour, Window, input_events
from conf.render.window.input_events import TextInput

NO_DISPLAY = (
    "no window can be opened: there is no display (DISPLAY is {display}); "
    "run in a desktop session, or draw without a window with --headless OUT.mp4"
)
NO_OPENGL = (
    "the display has no OpenGL 3.3: install a driver with `sudo apt install libgl1 libgl1-mesa-dri`, "
    "or draw without a window with --headless OUT.mp4"
)

CONTEXT_HINTS = (
    (glfw.CONTEXT_VERSION_MAJOR, 3),
    (glfw.CONTEXT_VERSION_MINOR, 3),
    (glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE),
    (glfw.OPENGL_FORWARD_COMPAT, True),
    (glfw.SCALE_TO_MONITOR, True),
    (glfw.DEPTH_BITS, 24),
)
# Keys whose names do not depend on the keyboard layout; GLFW names the others.
KEY_NAMES = {
    glfw.KEY_SPACE: "space",
    glfw.KEY_ESCAPE: "escape",
    glfw.KEY_HOME: "home",
    glfw.KEY_KP_0: "0",
    glfw.KEY_0: "0",
}
CLOSE_KEYS = {"escape", "q"}
MIN_SIZE = 64  # pixels a side
_CLIPBOARD_OWNER: Any = None  # GLFW takes no window for the clipboard any more, but its type stub asks for one


def _editing_key_code(name: str) -> int:
    """Return GLFW's code of one of EDITING_KEYS."""
    name = name.replace("_ctrl", "_control").replace("keypad_", "kp_").replace("_arrow", "")
    return int(getattr(glfw, f"KEY_{name.upper()}"))


EDITING_KEY_CODES = {_editing_key_code(name): name for name in input_events.EDITING_KEYS}


class _GlfwContextLoader(GpuObject):
    """Load OpenGL's functions through GLFW, which knows the window system: X11, Wayland, Windows or macOS."""

    def load_opengl_function(self, name: str) -> int:
        return int(glfw.get_proc_address(name) or 0)


class GlfwWindow(Window):
    """A window on a display."""

    def __init__(
        self,
        width: int,
        height: int,
        title: str,
        *,
        min_size: tuple[int, int] = (MIN_SIZE, MIN_SIZE),
        visible: bool = True,
    ) -> None:
        """Open the window. Raises GraphicsError if there is no display or no OpenGL 3.3.

        min_size : width and height below which the user cannot make it, points
        visible : whether it is shown at once
        """
        super().__init__(width, height)
        glfw.ERROR_REPORTING = "ignore"
        if not glfw.init():
            raise GraphicsError(NO_DISPLAY.format(display=os.environ.get("DISPLAY") or "not set"))
        for hint, value in CONTEXT_HINTS:
            glfw.window_hint(hint, value)
        glfw.window_hint(glfw.VISIBLE, visible)
        self._window = glfw.create_window(width, height, title, None, None)
        if not self._window:
            glfw.terminate()
            raise GraphicsError(NO_OPENGL)
        glfw.make_context_current(self._window)
        glfw.swap_interval(1)
        glfw.set_window_size_limits(self._window, *min_size, glfw.DONT_CARE, glfw.DONT_CARE)
        loader: dict[str, Any] = {"context": _GlfwContextLoader()}
        self.ctx = moderngl.create_context(require=330, **loader)
        self.framebuffer = self.ctx.screen
        self.size = self._framebuffer_size()  # larger than the window's size in points on a HiDPI display
        self._events: list[input_events.Event] = []
        self._cursor = glfw.get_cursor_pos(self._window)
        self._before_full_screen: tuple[int, int, int, int] | None = None
        glfw.set_key_callback(self._window, self._on_key)
        glfw.set_char_callback(self._window, lambda _, codepoint: self._events.append(TextInput(chr(codepoint))))
        glfw.set_cursor_pos_callback(self._window, self._on_cursor)
        glfw.set_mouse_button_callback(self._window, self._on_button)
        glfw.set_scroll_callback(self._window, lambda _, _dx, dy: self._events.append(input_events.Scrolled(dy)))
        set_drop_callback: Callable[..., Any] = glfw.set_drop_callback  # its type stub has other arguments
        set_drop_callback(self._window, lambda _, paths: self._events.append(input_events.FilesDropped(tuple(paths))))

    @property
    def pixel_ratio(self) -> float:
        return float(glfw.get_window_content_scale(self._window)[0])

    @property
    def should_close(self) -> bool:
        return bool(glfw.window_should_close(self._window))

    @should_close.setter
    def should_close(self, value: bool) -> None:
        glfw.set_window_should_close(self._window, value)

    @property
    def clipboard(self) -> str:
        text: Any = glfw.get_clipboard_string(
            _CLIPBOARD_OWNER
        )  # bytes, whatever its type stub says; None if it is no text
        return text.decode("utf-8", "replace") if text else ""

    @clipboard.setter
    def clipboard(self, value: str) -> None:
        glfw.set_clipboard_string(_CLIPBOARD_OWNER, value)

    @property
    def visible(self) -> bool:
        return bool(glfw.get_window_attrib(self._window, glfw.VISIBLE))

    @visible.setter
    def visible(self, value: bool) -> None:
        if value:
            glfw.show_window(self._window)
            glfw.focus_window(self._window)
        else:
            glfw.hide_window(self._window)

    def poll(self) -> list[input_events.Event]:
        glfw.poll_events()
        events, self._events = self._events, []
        return events

    def begin(self, colour: Colour = BLACK) -> None:
        glfw.make_context_current(self._window)
        self.size = self._framebuffer_size()
        self.framebuffer.viewport = (0, 0, *self.size)
        super().begin(colour)

    def end(self) -> None:
        glfw.swap_buffers(self._window)

    def toggle_full_screen(self) -> None:
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
        self.ctx.release()
        glfw.destroy_window(self._window)
        glfw.terminate()

    def _framebuffer_size(self) -> tuple[int, int]:
        width, height = glfw.get_framebuffer_size(self._window)
        return max(1, width), max(1, height)

    def _on_key(self, _window: object, key: int, scancode: int, action: int, _modifiers: int) -> None:
        if key in EDITING_KEY_CODES and action != glfw.REPEAT:
            self._events.append(input_events.KeyStateChanged(EDITING_KEY_CODES[key], action == glfw.PRESS))
        if action != glfw.PRESS:
            return
        name = KEY_NAMES.get(key) or (glfw.get_key_name(key, scancode) or "").lower()
        if name:
            self._events.append(input_events.KeyPressed(name))
        if self.close_on_escape and name in CLOSE_KEYS:
            self.should_close = True

    def _on_cursor(self, _window: object, x: float, y: float) -> None:
        dx, dy = x - self._cursor[0], y - self._cursor[1]
        self._cursor = (x, y)
        self._events.append(input_events.MouseMoved(*self._to_pixels(x, y)))
        mode = self._drag_mode()
        if mode:
            height = max(1, glfw.get_window_size(self._window)[1])
            self._events.append(input_events.Dragged(mode, dx / height, -dy / height))

    def _drag_mode(self) -> str | None:
        def is_held(button: int) -> bool:
            return bool(glfw.get_mouse_button(self._window, button) == glfw.PRESS)

        if is_held(glfw.MOUSE_BUTTON_LEFT):
            shift = (glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SHIFT)
            return "pan" if any(glfw.get_key(self._window, key) == glfw.PRESS for key in shift) else "orbit"
        return "pan" if is_held(glfw.MOUSE_BUTTON_MIDDLE) else None

    def _on_button(self, _window: object, button: int, action: int, _modifiers: int) -> None:
        position = self._to_pixels(*glfw.get_cursor_pos(self._window))
        self._events.append(input_events.MouseButton(button, action == glfw.PRESS, *position))

    def _to_pixels(self, x: float, y: float) -> tuple[float, float]:
        """Convert a position in the window from points to framebuffer pixels."""
        ratio = self.size[0] / max(1, glfw.get_window_size(self._window)[0])
        return x * ratio, y * ratio
