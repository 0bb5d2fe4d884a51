"""`conf demo`: a call on one machine. The sample clip is the camera, the datagrams go over real UDP."""

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from conf.commands.receive import Showing, receive
from conf.errors import ConfError
from conf.protocol.statistics import TrafficSnapshot
from conf.receiver.udp import ReceiverSocket
from conf.sender.models import fetch_demo_clip

LOOPBACK = "127.0.0.1"


@dataclass(frozen=True)
class Demo:
    """What a demo left behind: the figures, and the files of one without a display."""

    traffic: TrafficSnapshot
    clip: Path | None
    picture: Path | None


def demo(*, seconds: float | None, headless: bool) -> Demo:
    """Run sender and receiver until the window is closed or the time is over.

    Raises ConfError when one of the two cannot run.
    """
    clip = Path("conf-demo.avi") if headless else None
    picture = Path("conf-demo.jpg") if headless else None
    film = fetch_demo_clip()
    with ReceiverSocket(LOOPBACK, 0) as link:
        host, port = link.address
        command = [sys.executable, "-m", "conf", "send", f"{host}:{port}", "--file", str(film), "--loop", "--json"]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as sender:
            try:
                traffic = receive(link, Showing(clip, picture, seconds), keep_going=lambda: sender.poll() is None)
            finally:
                sender.terminate()
                _, words = sender.communicate()
    if not traffic.frames_received:
        raise ConfError(f"no frame came through: {words.strip() or 'the sender said nothing'}")
    return Demo(traffic, clip, picture)
