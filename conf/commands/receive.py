"""`conf receive`: listen, and show who calls."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from conf.face.loading import load_face
from conf.output.media_writer import save_picture
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.session.server import SessionServer
from conf.protocol.statistics import TrafficSnapshot
from conf.receiver.pipeline import ReceivingLoop
from conf.receiver.viewer_controls import ConstantRateRecorder
from conf.render.window.glfw_window import GlfwWindow
from conf.render.window.offscreen import OffscreenWindow
from conf.transport.udp import UdpSocket

SIZE = (640, 480)
WINDOW_FPS = 60.0
HEADLESS_FPS = 30.0


@dataclass(frozen=True)
class ReceiveOptions:
    """How the picture is shown.

    headless : AVI to draw into instead of a window
    picture : JPG of the last picture, for headless drawing
    """

    headless: Path | None = None
    picture: Path | None = None
    seconds: float | None = None
    on_event: Callable[[str], None] | None = None


def has_display() -> bool:
    """Say whether there is a screen to open a window on."""
    return os.name != "posix" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def receive(
    link: UdpSocket,
    code: str,
    showing: ReceiveOptions,
    *,
    face: Path | None = None,
    should_continue: Callable[[], bool] = lambda: True,
) -> TrafficSnapshot:
    """Show what comes over a link. Returns the figures of the traffic.

    code : what callers must know, as normalise_code returns it

    Raises GraphicsError, FileFormatError, RecordingError.
    """
    model = load_face(face)
    host = ReceiverEndpoint(SessionServer(code, os.urandom))
    greeting = "listening on {}:{}   code  {}".format(*link.address, code)
    if showing.headless is None:
        with GlfwWindow(*SIZE, "conf") as window:
            loop = ReceivingLoop(window, model, host, link, idle_text=greeting)
            return loop.run(
                fps=WINDOW_FPS, seconds=showing.seconds, keep_going=should_continue, on_event=showing.on_event
            )
    with OffscreenWindow(*SIZE) as window:
        loop = ReceivingLoop(window, model, host, link, idle_text=greeting)
        return _record(window, loop, showing, should_continue)


def _record(
    window: OffscreenWindow, loop: ReceivingLoop, showing: ReceiveOptions, should_continue: Callable[[], bool]
) -> TrafficSnapshot:
    assert showing.headless is not None
    clip = ConstantRateRecorder(showing.headless, fps=HEADLESS_FPS)
    try:
        return loop.run(
            fps=HEADLESS_FPS,
            seconds=showing.seconds,
            keep_going=should_continue,
            on_picture=clip.add,
            on_event=showing.on_event,
        )
    finally:
        clip.close()
        if showing.picture is not None:
            save_picture(showing.picture, window.read())
