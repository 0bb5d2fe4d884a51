"""The switches of one's own end of a call, and the keys and buttons that change them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from conf.receiver.panel_layout import Rect
from conf.receiver.viewer_controls import KeyTable, action_of
from conf.render.window.input_events import Dragged, Event, KeyPressed, MouseButton, MouseMoved

# key -> (action, help text), as in viewer_controls.
CALL_KEYS: KeyTable = {
    "m": ("microphone", "mute your microphone, microphone on"),
    "c": ("camera", "your camera off, camera on"),
    "p": ("own portrait", "send pictures of yourself, or none"),
    "r": ("record video", "record a clip (MP4), stop recording"),
    "o": ("self view", "see yourself, or what the other sees of you"),
    "v": ("portrait", "the other's own picture, or the head"),
    "i": ("stats", "what the call costs"),
    "s": ("save image", "save a picture (JPG)"),
    "d": ("record motion", "record the motion received (DPC), stop recording"),
    "u": ("mute sound", "mute the sound, sound on"),
    "+": ("louder", "louder"),
    "=": ("louder", ""),
    "-": ("quieter", "quieter"),
    "f": ("full screen", "full screen"),
    "h": ("help", "this help"),
    "home": ("reset", "look straight again"),
    "0": ("reset", ""),
    "escape": ("quit", "hang up"),
    "q": ("quit", ""),
}
BUTTONS = ("microphone", "camera", "own portrait", "record video", "quit")  # from left to right
NO_MICROPHONE = "there is no microphone: start with --microphone, `conf devices` lists them"
PORTRAIT_ON = "pictures of you are sent from now on; P stops that"
PORTRAIT_OFF = "no more pictures of you are sent: the other sees the head again"


@dataclass
class LocalState:
    """What the person at this end has switched on; the loop carries it out.

    camera : whether the face is to be captured and sent
    camera_fault : why there is no image though the camera is on, "" while there is nothing wrong
    microphone : whether the voice is sent
    portrait : whether images of the person may be sent
    has_microphone : whether there is one
    """

    camera: bool = True
    microphone: bool = True
    portrait: bool = False
    has_microphone: bool = True
    camera_fault: str = ""

    @property
    def shows_face(self) -> bool:
        """Whether the camera is on and works."""
        return self.camera and not self.camera_fault


@dataclass(frozen=True)
class ButtonPlace:
    """A button of the last frame. rect : pixels"""

    action: str
    rect: Rect


class CallControls:
    """Carries out keys and clicks that concern one's own end; the rest is left to ViewerControls.

    sees_sent : whether one's own corner shows what the other sees, rather than the camera's image
    hovered : the action of the button under the mouse, None without one
    buttons : of the last frame, set by whoever draws them
    """

    def __init__(self, state: LocalState) -> None:
        self.sees_sent = False
        self.hovered: str | None = None
        self.buttons: Sequence[ButtonPlace] = ()
        # Set by the owner: shows a message; carries out an action of ViewerControls.
        self.show_toast: Callable[[str, float], None] = lambda text, now: None
        self.run_action: Callable[[str, float], None] = lambda action, now: None
        self._state = state
        self._is_pressed = False  # a button, with the mouse

    def intercept(self, event: Event, now: float) -> bool:
        """Deal with an event, and return whether nobody else is to."""
        match event:
            case KeyPressed():
                return self._run(str(action_of(event, CALL_KEYS)), now)
            case MouseMoved(x=x, y=y):
                self.hovered = self._button_at(x, y)
            case MouseButton(button=0, pressed=True, x=x, y=y) if action := self._button_at(x, y):
                self._is_pressed = True
                if not self._run(action, now):
                    self.run_action(action, now)
                return True
            case MouseButton(button=0, pressed=False):
                self._is_pressed = False
            case Dragged():
                return self._is_pressed
        return False

    def _button_at(self, x: float, y: float) -> str | None:
        inside = (
            button.action
            for button in self.buttons
            if button.rect.left <= x < button.rect.right and button.rect.top <= y < button.rect.bottom
        )
        return next(inside, None)

    def _run(self, action: str, now: float) -> bool:
        """Carry out an action if it is one of these."""
        state = self._state
        match action:
            case "microphone" if not state.has_microphone:
                self.show_toast(NO_MICROPHONE, now)
            case "microphone":
                state.microphone = not state.microphone
            case "camera":
                state.camera = not state.camera
                if state.camera and state.camera_fault:
                    self.show_toast(state.camera_fault, now)
            case "own portrait":
                state.portrait = not state.portrait
                self.show_toast(PORTRAIT_ON if state.portrait else PORTRAIT_OFF, now)
            case "self view":
                self.sees_sent = not self.sees_sent
            case _:
                return False
        return True
