"""Run one end of a real call as `conf send` or `conf receive` does, and log every frame and every drawn image.

    python tools/bench/call_probe.py receive 127.0.0.1:0 CODE SECONDS [--fps N] [--speaker N|NAME]
    python tools/bench/call_probe.py send 127.0.0.1:5005 CODE SECONDS CLIP|MOTION.dpc [--sound FILE] [--portrait]

Prints JSON, one object a line. The receiver prints the address it listens on, then each second its figures, the images
it has drawn and when each caller's portrait was first drawn. The sender prints each second its memory, when the call
started, the frames it has captured, those it has sent and the datagrams. All times are of the machine's monotonic
clock, which both processes share. The face is drawn but not recorded. With --speaker the voice is played
(sound_probe.py).
Used by tools/network/soak.py and by latency.py, flood.py and portrait_start.py in tools/bench.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import asdict
from pathlib import Path
from typing import IO, Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.commands.send import SendOptions
from conf.commands.send import send as send_face
from conf.commands.support.display import HEADLESS_SIZE, WINDOW_FPS
from conf.commands.support.garbage import frozen_memory
from conf.errors import NetworkError
from conf.face.loading import load_face
from conf.protocol import send_leg
from conf.protocol.address import Address
from conf.protocol.messages import MotionFrame
from conf.protocol.motion.outbound import OutboundMotion
from conf.protocol.outgoing import OutgoingBody
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.session.server import SessionServer
from conf.protocol.statistics import HEADER_BYTES
from conf.receiver.call_display import LoopOptions
from conf.receiver.pipeline import ReceiverLoop
from conf.render.window.offscreen import OffscreenWindow
from conf.sender import pipeline
from conf.sender.face_capture import CapturedMotion
from conf.sender.pipeline import SenderLoop, SenderStatus
from conf.transport.udp import UdpSocket
from tools.bench.sound_probe import WatchedSound

LOG_INTERVAL_S = 1.0


def memory_kb() -> int:
    """Return the resident memory of this process (RSS), kB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") // 1024


def log(**values: Any) -> None:
    """Print one JSON object."""
    print(json.dumps(values), flush=True)


SENT: list[float] = []  # stream time of the newest frame of each datagram sent, since the last log


class WatchedMotion(OutboundMotion):
    """An outgoing motion stream that logs which frames were sent: a face that holds still is not sent."""

    def on_sent(self, counter: int, outgoing: OutgoingBody) -> None:
        """Record what was sent."""
        super().on_sent(counter, outgoing)
        if outgoing.frame_numbers:
            SENT.append(outgoing.frame_numbers[-1] / self.profile.fps)


def sent_since_log() -> list[float]:
    """Return the stream times of what was sent since the last call."""
    times = SENT[:]
    del SENT[: len(times)]
    return times


class WatchedWindow(OffscreenWindow):
    """An offscreen window that logs when each image was finished and what it showed.

    pictures : (finished at, playhead on the stream's clock, s the playhead is past the newest frame)
    portraits : time at which the portrait of each caller was first drawn
    """

    def __init__(self, host: ReceiverEndpoint, sound: WatchedSound | None = None) -> None:
        super().__init__(*HEADLESS_SIZE)
        self.sound = sound
        self.pictures: list[tuple[float, float, float]] = []
        self.portraits: dict[int, float] = {}
        self._host = host
        self._due = 0.0

    def end(self) -> None:
        """Finish the image and log it."""
        self.finish()
        now = time.monotonic()
        self.pictures += [
            (now, float(leg.motion.buffer.playhead), max(0.0, float(leg.motion.buffer.playhead) - newest))
            for leg in self._host.streams.values()
            if (newest := leg.motion.buffer.newest) is not None
        ]
        if now >= self._due:
            self._due = now + LOG_INTERVAL_S
            missed = sum(leg.missed_references for leg in self._host.streams.values())
            counts = {"callers": len(self._host.streams), "missed_references": missed, "portraits": self.portraits}
            if self.sound:
                counts |= self.sound.figures()
            log(at=now, memory_kb=memory_kb(), **counts, **asdict(self._host.snapshot(now)), pictures=self.pictures)
            self.pictures = []


class WatchedReceiverLoop(ReceiverLoop):
    """A receiver loop that logs when the portrait of each caller was first drawn."""

    def step(self, now: float) -> float:
        due = super().step(now)
        window = self._composer._window
        assert isinstance(window, WatchedWindow)
        for caller, portrait in self._composer._grid._portraits.items():
            if portrait.ready and self._composer._frames.get(caller):
                window.portraits.setdefault(caller, time.monotonic())
        if window.sound and self._display._schedule._drawing_since is not None:
            window.sound.on_frames_drawn(self._composer._frames.values(), time.monotonic())
        return due


class WatchedSendingLoop(SenderLoop):
    """A sender loop that logs when the call started, when each frame was captured, and what was sent.

    datagrams : (sent at, bytes with headers, bytes of the portrait among them)
    """

    frames: list[tuple[float, float]]
    datagrams: list[tuple[float, int, int]]
    began = captured_at = due = 0.0

    def run(
        self,
        *,
        seconds: float | None = None,
        on_status: Callable[[SenderStatus], None] | None = None,
        should_continue: Callable[[], bool] = lambda: True,
        clock: Callable[[], float] = time.monotonic,
    ) -> SenderStatus:
        """Send, logging from now on."""
        self.began = time.monotonic()
        self.datagrams = []
        put, before = self._socket.send, 0
        source = self._capture._source
        track = source.motion

        def motion() -> MotionFrame | None:
            self.captured_at = time.monotonic()
            return track()

        def send(datagrams: list[tuple[bytes, Address]]) -> None:
            nonlocal before
            total = self._connection._send.budget.chunks.bytes_sent
            if datagrams:
                size = sum(len(data) + HEADER_BYTES for data, _ in datagrams)
                self.datagrams.append((time.monotonic(), size, total - before))
            before = total
            put(datagrams)

        self._socket.send = send  # type: ignore[method-assign]
        source.motion = motion  # type: ignore[method-assign]
        return super().run(seconds=seconds, on_status=on_status, should_continue=should_continue, clock=clock)

    def _send(self, captured: CapturedMotion, now: float) -> None:
        self.frames = [*getattr(self, "frames", []), (self.captured_at, captured.timestamp)]
        super()._send(captured, now)
        if self.captured_at >= self.due:
            self.due = self.captured_at + LOG_INTERVAL_S
            logged = {"frames": self.frames, "datagrams": self.datagrams, "sent": sent_since_log()}
            log(at=self.captured_at, began=self.began, memory_kb=memory_kb(), **logged, **asdict(self.status(now)))
            self.frames, self.datagrams = [], []


def receive(
    address: tuple[str, int], code: str, seconds: float, *, fps: float = WINDOW_FPS, speaker: str | None = None
) -> None:
    """Receive as `conf receive` does, at the frame rate of its window. speaker : what plays the voice, None for none"""
    callers = ReceiverEndpoint(SessionServer(code, os.urandom))
    sound = WatchedSound(callers.streams, speaker) if speaker is not None else None
    window = WatchedWindow(callers, sound)
    with UdpSocket.bind(*address) as link, window, sound.output if sound else nullcontext() as output:
        log(listening="{}:{}".format(*link.address))
        loop = WatchedReceiverLoop(window, load_face(None), callers, link, LoopOptions(fps, sound=output))
        with frozen_memory():
            final = loop.run(seconds=seconds)
        log(at=time.monotonic(), memory_kb=memory_kb(), **asdict(final), pictures=window.pictures)


def send(receiver: tuple[str, int], code: str, send_options: SendOptions) -> None:
    """Send a looped clip as `conf send` does."""
    send_leg.OutboundMotion = WatchedMotion  # type: ignore[attr-defined]
    pipeline.SenderLoop = WatchedSendingLoop  # type: ignore[misc]
    send_face(receiver, code, send_options)


def start(*arguments: object, program: str = __file__) -> subprocess.Popen[str]:
    """Start this program, or another with such a log, in another process."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    command = [sys.executable, program, *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)


def start_receiver(code: str, seconds: float, *options: object) -> tuple[subprocess.Popen[str], str]:
    """Start a receiver on loopback; return it and its address."""
    receiver = start("receive", "127.0.0.1:0", code, seconds, *options)
    assert receiver.stdout is not None
    return receiver, json.loads(receiver.stdout.readline())["listening"]


def read_lines(stream: IO[str], into: list[dict[str, Any]]) -> None:
    """Append every object that a probe prints, until it ends; meant to run in a thread."""
    for line in stream:
        into.append(json.loads(line))


def split_address(text: str) -> tuple[str, int]:
    """Return host and port."""
    host, _, port = text.rpartition(":")
    return host, int(port)


def main() -> None:
    """Run one end of the call."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("side", choices=["receive", "send"])
    parser.add_argument("address", type=split_address)
    parser.add_argument("code")
    parser.add_argument("seconds", type=float)
    parser.add_argument("clip", type=Path, nargs="?")
    parser.add_argument("--portrait", action="store_true", help="send images of the person too")
    parser.add_argument("--sound", type=Path, help="send the sound of a file")
    parser.add_argument("--microphone", help="send what a microphone captures: a number or name as of `conf devices`")
    parser.add_argument("--kbps", type=float, help="send no more than this")
    parser.add_argument("--fps", type=float, default=WINDOW_FPS, help="frames drawn a second")
    parser.add_argument("--speaker", help="play the voice: a number or name as of `conf devices`, or null")
    options = parser.parse_args()
    if options.side == "receive":
        receive(options.address, options.code, options.seconds, fps=options.fps, speaker=options.speaker)
        return
    is_motion = options.clip.suffix == ".dpc"
    send_options = SendOptions(
        file=None if is_motion else options.clip,
        dpc=options.clip if is_motion else None,
        loop=True,
        seconds=options.seconds,
        portrait_kbps=4.0 if options.portrait else None,
        kbps=options.kbps,
        sound=options.sound,
        microphone=options.microphone,
    )
    try:
        send(options.address, options.code, send_options)
    except NetworkError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
