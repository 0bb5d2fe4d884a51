"""`conf receive`: listen, and show who calls."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from conf.face.head import FaceModel, load_face
from conf.protocol.inbound import Inbound
from conf.protocol.statistics import TrafficSnapshot
from conf.receiver.offscreen import OffscreenWindow
from conf.receiver.pipeline import ReceivingLoop
from conf.receiver.recorder import save_picture
from conf.receiver.stage import Window
from conf.receiver.udp import ReceiverSocket
from conf.receiver.viewer import TimedClip
from conf.receiver.window import GlfwWindow

SIZE = (640, 480)
WINDOW_FPS = 60.0
HEADLESS_FPS = 30.0


@dataclass(frozen=True)
class Showing:
    """How the picture is shown.

    headless : AVI to draw into instead of a window
    picture : JPG of the last picture, for headless drawing
    """

    headless: Path | None = None
    picture: Path | None = None
    seconds: float | None = None


def has_display() -> bool:
    """Say whether there is a screen to open a window on."""
    return os.name != "posix" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def receive(
    link: ReceiverSocket,
    showing: Showing,
    *,
    face: Path | None = None,
    keep_going: Callable[[], bool] = lambda: True,
) -> TrafficSnapshot:
    """Show what comes over a link. Returns the figures of the traffic.

    Raises GraphicsError, FileFormatError, RecordingError.
    """
    model = load_face(face)
    if showing.headless is None:
        with GlfwWindow(*SIZE, "conf") as window:
            return _loop(window, model, link).run(fps=WINDOW_FPS, seconds=showing.seconds, keep_going=keep_going)
    with OffscreenWindow(*SIZE) as window:
        return _record(window, model, link, showing, keep_going)


def _loop(window: Window, model: FaceModel, link: ReceiverSocket) -> ReceivingLoop:
    return ReceivingLoop(window, model, Inbound(), link)


def _record(
    window: OffscreenWindow,
    model: FaceModel,
    link: ReceiverSocket,
    showing: Showing,
    keep_going: Callable[[], bool],
) -> TrafficSnapshot:
    assert showing.headless is not None
    clip = TimedClip(showing.headless, fps=HEADLESS_FPS)
    try:
        return _loop(window, model, link).run(
            fps=HEADLESS_FPS, seconds=showing.seconds, keep_going=keep_going, on_picture=clip.add
        )
    finally:
        clip.close()
        if showing.picture is not None:
            save_picture(showing.picture, window.read())
