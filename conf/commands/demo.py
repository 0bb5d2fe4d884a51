"""`conf demo`: a call on one machine. The sample clip replaces the camera; the datagrams use real UDP.

The clip, in which a man begins to smile, is short. It is played forwards and backwards in turn: as a loop from its end
to its start his face would jump.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from conf.commands import Terminal
from conf.commands.receive import ReceiveOptions, receive
from conf.commands.support.arguments import add_json, add_seconds
from conf.commands.support.call_table import call_table
from conf.commands.support.child_process import start_conf
from conf.commands.support.display import has_display
from conf.commands.support.sound import add_no_sound
from conf.errors import ConfError
from conf.settings import PATH_VARIABLE

if TYPE_CHECKING:
    from conf.protocol.call_report import CallReport

HELP = "a call on this machine: the sample clip over real UDP, in a window with traffic figures"
HEADLESS_SECONDS = 20.0
LOOPBACK = "127.0.0.1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_seconds(parser, f" (without a display: {HEADLESS_SECONDS:.0f})")
    parser.add_argument("--headless", action="store_true", help="no window: write conf-demo.mp4 and conf-demo.jpg")
    parser.add_argument("--file", type=Path, metavar="CLIP", help="a clip of your own, with its sound")
    add_no_sound(parser, "neither send nor play sound")
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    headless = options.headless or not has_display()
    seconds = options.seconds or (HEADLESS_SECONDS if headless else None)
    call = demo(
        seconds=seconds, headless=headless, file=options.file, sound=not options.no_sound, on_report=terminal.write
    )
    terminal.print_figures("the call", call, call_table(call))


def demo(
    *,
    seconds: float | None,
    headless: bool,
    file: Path | None = None,
    sound: bool = True,
    on_report: Callable[[str], None] = lambda text: None,
) -> CallReport:
    """Run sender and receiver until the window is closed, the time is over or the user interrupts.

    file : a clip in place of the sample; sound : send and play its sound
    on_report : called at the end, with the full path of each file written
    Raises ConfError if one of the two cannot run.
    """
    import tempfile

    from conf.protocol.address import format_address
    from conf.protocol.session.pairing_code import generate_code
    from conf.sender.tracking.model_files import fetch_demo_clip
    from conf.transport.udp import UdpSocket

    clip = Path("conf-demo.mp4") if headless else None
    picture = Path("conf-demo.jpg") if headless else None
    with tempfile.TemporaryDirectory(prefix="conf-demo-") as folder, UdpSocket.bind(LOOPBACK, 0) as socket:
        clip_file = file or there_and_back(fetch_demo_clip(), Path(folder) / "clip.mp4")
        code = generate_code(os.urandom)
        receiver = format_address(socket.address)
        # The code is not on the command line, because every user of the machine can read that.
        arguments = ["send", receiver, "--file", str(clip_file), "--loop", "--json"]
        arguments += [] if sound else ["--no-sound"]
        with start_conf(arguments, environment={"CONF_CODE": code, PATH_VARIABLE: os.devnull}) as sender:
            try:
                receive_options = ReceiveOptions(
                    clip, picture, on_report=on_report, sound=sound, seconds=seconds, waiting=f"listening on {receiver}"
                )
                call = receive(socket, code, receive_options, should_continue=lambda: sender.poll() is None)
            finally:
                sender.terminate()
                _, message = sender.communicate()
    if not call.frames_received:
        raise ConfError(f"no frame was received: {message.strip() or 'the sender printed no reason'}")
    return call


def there_and_back(clip: Path, output: Path) -> Path:
    """Write a clip that shows another one forwards and then backwards, without repeating the first and last frame.

    Returns output. Raises CameraError, RecordingError.
    """
    from conf.output.video_writer import VideoWriter
    from conf.sender.capture.clip import open_clip

    with open_clip(clip) as source, VideoWriter(output, fps=source.fps) as writer:
        frames = [frame.pixels for frame in iter(source.read, None)]
        for pixels in [*frames, *frames[-2:0:-1]]:
            writer.write(pixels)
    return output
