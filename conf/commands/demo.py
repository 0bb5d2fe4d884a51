"""`conf demo`: a call on one machine. The sample clip is the camera, the datagrams go over real UDP."""

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from conf.commands.receive import ReceiveOptions, receive
from conf.errors import ConfError
from conf.protocol.session.pairing_code import generate_code
from conf.protocol.statistics import TrafficSnapshot
from conf.sender.tracking.model_files import fetch_demo_clip
from conf.transport.udp import UdpSocket

LOOPBACK = "127.0.0.1"
CODE_VARIABLE = "CONF_CODE"


@dataclass(frozen=True)
class DemoResult:
    """What a demo left behind: the figures, and the files of one without a display."""

    traffic: TrafficSnapshot
    clip: Path | None
    picture: Path | None


def demo(*, seconds: float | None, headless: bool) -> DemoResult:
    """Run sender and receiver until the window is closed or the time is over.

    Raises ConfError when one of the two cannot run.
    """
    clip = Path("conf-demo.avi") if headless else None
    picture = Path("conf-demo.jpg") if headless else None
    sample_clip = fetch_demo_clip()
    with UdpSocket.bind(LOOPBACK, 0) as link:
        host, port = link.address
        code = generate_code(os.urandom)
        command = [
            sys.executable,
            "-m",
            "conf",
            "send",
            f"{host}:{port}",
            "--file",
            str(sample_clip),
            "--loop",
            "--json",
        ]
        secret = os.environ | {CODE_VARIABLE: code}  # not on the command line, where every user of the machine sees it
        with subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=secret
        ) as sender:
            try:
                showing = ReceiveOptions(clip, picture, seconds)
                traffic = receive(link, code, showing, should_continue=lambda: sender.poll() is None)
            finally:
                sender.terminate()
                _, words = sender.communicate()
    if not traffic.frames_received:
        raise ConfError(f"no frame came through: {words.strip() or 'the sender said nothing'}")
    return DemoResult(traffic, clip, picture)
