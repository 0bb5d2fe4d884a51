"""Make the images of a call in README from the demo's clip and from Carphone.

    xvfb-run -s "-screen 0 1280x1024x24" python tools/docs/screenshots.py [--offscreen]

- start.jpg: the start window, with stand-ins for microphone and speaker
- receiver.jpg: the window of the receiver during a call
- before_after.jpg: frames of the person, and their drawings
- stages.png: the plot of `conf measure`

The call runs through the receiver's loop, datagrams included, in simulated time, so that the images do not depend on
the speed of the machine.
"""

import argparse
import os
import sys
import tempfile
import time
from dataclasses import astuple
from datetime import UTC, datetime, timedelta
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.audio.devices import SoundDevice
from conf.commands.measure import measure, plot
from conf.commands.start import code_in, connected_with, says_end, start_animator, start_call
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.loading import load_face
from conf.protocol.address import Address
from conf.protocol.codec.profiles import LIVE
from conf.protocol.loopback import ONE_WAY_S, RECEIVER, LoopbackCall
from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.rate_control.send_budget import RateOptions
from conf.receiver.call_display import LoopOptions
from conf.receiver.pipeline import ReceiverLoop
from conf.render.window import Window
from conf.render.window.glfw_window import GlfwWindow
from conf.render.window.input_events import Event, KeyPressed
from conf.render.window.offscreen import OffscreenWindow
from conf.sender.capture.camera_list import CameraDevice
from conf.sender.capture.clip import open_clip
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.tracking.canonical_face import load_canonical_face
from conf.sender.tracking.model_files import fetch_demo_clip
from conf.sender.tracking.offline import track_clip
from conf.settings import change_settings
from conf.start.app import StartApp
from conf.start.controller import Files, Programs, StartController
from conf.start.devices.choices import DeviceLists
from conf.start.recent_calls import RecentCall, save_recent_calls
from conf.transport.udp import DIRECT
from tools.bench.carphone import fetch_carphone
from tools.bench.fidelity import Pair, run

Pixels = NDArray[np.uint8]

DOCS = Path(__file__).resolve().parents[2] / "docs"
SIZE = (1280, 720)
FPS = 30.0
LOOPS = 5  # repetitions of the clip, so that the statistics overlay has data
QUALITY = [cv2.IMWRITE_JPEG_QUALITY, 88]
LIPS = CONTROL_POINT_INDEX["inner_lip_lower_mid"], CONTROL_POINT_INDEX["inner_lip_upper_mid"]
LIDS = [(CONTROL_POINT_INDEX[f"eyelid_upper_{side}"], CONTROL_POINT_INDEX[f"eyelid_lower_{side}"]) for side in "lr"]
COLUMN = 300
START_SIZE = (1000, 640)
FRAME_SHOWN = 40  # of the clip, in the start window
CAPTION = 34


class SimulatedSocket:
    """Socket and clock of the receiver's loop; while the loop waits, the sender sends the frames that are due."""

    candidates = ()
    nameplate = ""
    others_wait = False

    def __init__(self, call: LoopbackCall, frames: list[MotionFrame]) -> None:
        self.now = 0.0
        self._call = call
        self._frames = list(reversed(frames))

    def clock(self) -> float:
        """Return the simulated time in seconds."""
        return self.now

    def path_name(self, address: Address) -> str:
        """Return how datagrams reach an address."""
        return DIRECT

    def receive(self, limit: int = 4096) -> list[tuple[bytes, Address]]:
        """Return nothing: LoopbackCall delivers the sender's datagrams to the receiver."""
        return []

    def send(self, datagrams: list[tuple[bytes, Address]]) -> None:
        """Deliver the receiver's datagrams to the sender."""
        for data, _ in datagrams:
            self._call.sender.receive_datagram(data, RECEIVER, self.now)

    def wait(self, seconds: float) -> None:
        """Advance the simulated time."""
        self.now += max(min(seconds, 1 / 60), 1e-4)
        while self._frames and self._frames[-1].timestamp <= self.now:
            frame = self._frames.pop()
            self._call.send_frame(frame, frame.timestamp)


def main() -> None:
    """Write the images and print their paths."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--offscreen", action="store_true", help="draw offscreen; the image is the same")
    parser.add_argument("--output", type=Path, default=DOCS, help="folder of the images")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    clip = fetch_carphone()  # it moves more than the demo's
    with OffscreenWindow(*SIZE) if options.offscreen else GlfwWindow(*SIZE, "conf") as window:
        cv2.imwrite(str(options.output / "receiver.jpg"), receiver_image(window, fetch_demo_clip()), QUALITY)
    cv2.imwrite(str(options.output / "before_after.jpg"), before_after(list(run(clip))), QUALITY)
    plot(measure(clip), options.output / "stages.png")
    cv2.imwrite(str(options.output / "start.jpg"), start_image(fetch_demo_clip()), QUALITY)
    for name in ("start.jpg", "stages.png", "before_after.jpg", "receiver.jpg"):
        path = options.output / name
        print(f"{path}: {path.stat().st_size / 1000:.0f} kB")


def receiver_image(window: Window, clip: Path) -> Pixels:
    """Return the image of the window at the most expressive frame of the last repetition of the clip."""
    frames, parameters = motion(clip)
    length = frames[-1].timestamp + 1 / parameters.fps
    looped = [
        MotionFrame(frame.timestamp + i * length, frame.displacements, frame.pose)
        for i in range(LOOPS)
        for frame in frames
    ]
    call = LoopbackCall(parameters, 0.0, os.urandom, rate=RateOptions(LIVE.name))
    socket = SimulatedSocket(call, looped)
    keys: list[Event] = [KeyPressed("m")]  # opens the statistics
    window.poll = lambda: [keys.pop()] if keys else []  # type: ignore[method-assign]
    best: list[tuple[float, Pixels]] = []

    def keep(window: Window, now: float) -> None:
        if now > (LOOPS - 1) * length:
            played = now - ONE_WAY_S - call.stream.snapshot(now).playout_delay_ms / 1000
            nearest = min(looped, key=lambda frame: abs(frame.timestamp - played))
            if not best or expressiveness(nearest) > best[0][0]:
                best[:] = [(expressiveness(nearest), window.read())]

    loop = ReceiverLoop(window, load_face(), call.receiver, socket, LoopOptions(FPS, on_frame=keep))  # type: ignore[arg-type]
    loop.run(seconds=LOOPS * length, clock=socket.clock)
    return best[0][1]


def start_image(clip: Path) -> Pixels:
    """Return the image of the start window with a clip as the camera."""
    now = datetime.now(UTC)
    with tempfile.TemporaryDirectory() as folder, OffscreenWindow(*START_SIZE) as window:
        files = Files(Path(folder) / "settings.toml", Path(folder) / "recent_calls.json")
        change_settings(files.settings, {"name": "Anna", "camera": str(clip), "kbps": 16.0})
        calls = (RecentCall("192.0.2.17", now, "Bea"), RecentCall("office.example.org", now - timedelta(1), "Chris"))
        save_recent_calls(files.recent_calls, calls)
        programs = Programs(start_call, start_animator, connected_with, says_end, code_in)
        controller = StartController(programs, files, random=os.urandom)
        app = StartApp(window, controller)
        images: list[Pixels] = []
        window.end = lambda: images.append(window.read())  # type: ignore[method-assign]
        while controller.devices is None or controller.camera is None or controller.camera.newest()[0] < FRAME_SHOWN:
            time.sleep(1 / FPS)
        sound = SoundDevice(0, "Headset")
        controller.devices = DeviceLists((CameraDevice(0, "Webcam"),), (sound,), (sound,))
        controller.set_setting("camera", None)
        controller.microphone, controller.camera = Level(), controller._closing[-1]  # type: ignore[assignment]
        for number in range(3):
            app.step(float(number))
        app.close()
        controller.microphone = None
        controller.close()
    return images[-1]


class Level:
    """A microphone into which somebody talks."""

    error = ""
    level = 0.62


def motion(clip: Path) -> tuple[list[MotionFrame], StreamParameters]:
    """Return the frames of a clip at the rate of the live profile, and the parameters of the stream."""
    with open_clip(clip) as source:
        size, fps = source.size, source.fps
    extractor = MotionExtractor(load_canonical_face(), size)
    tracked = [(frame.timestamp, tracking) for frame, tracking in track_clip(clip)]
    for timestamp, tracking in tracked:
        if tracking is not None:
            extractor.update(tracking, timestamp)
    extractor.restart()
    frames = [extractor.update(tracking, timestamp) for timestamp, tracking in tracked if tracking is not None]
    step = max(1, round(fps / LIVE.fps))
    return frames[::step], StreamParameters(*size, LIVE.fps, 50, astuple(extractor.fapu))


def expressiveness(frame: MotionFrame) -> float:
    """Return a score of a frame: high for an open mouth, open eyes and little head rotation."""
    up = frame.displacements[:, 1]
    mouth = min(float(up[LIPS[1]] - up[LIPS[0]]), 350.0)
    closure = sum(max(0.0, float(up[lower] - up[upper])) for upper, lower in LIDS)
    return mouth - 0.6 * closure - 400.0 * float(np.abs(frame.pose[:3]).sum())


def before_after(pairs: list[Pair]) -> Pixels:
    """Return columns for four expressions: person, drawing, caption."""
    mouth = [pair.source["mouth_opening"] for pair in pairs]
    lids = [pair.source["lid_left"] + pair.source["lid_right"] for pair in pairs]
    roll = [abs(pair.source["roll"]) for pair in pairs]
    brows = [pair.source["brow_inner"] + pair.source["brow_outer"] for pair in pairs]
    selected = {
        "mouth wide open": np.argmax(mouth),
        "eyes shut": np.argmin(lids),
        "head tilted": np.argmax(roll),
        "brows raised": np.argmax(np.array(brows) - np.array(mouth)),
    }
    return np.hstack([column(pairs[int(i)], text) for text, i in selected.items()])


def column(pair: Pair, text: str) -> Pixels:
    """Return (H, COLUMN, 3): person, drawing, caption."""
    height = round(COLUMN * pair.pixels.shape[0] / pair.pixels.shape[1])
    person = cv2.resize(pair.pixels, (COLUMN, height), interpolation=cv2.INTER_CUBIC)
    drawing = cv2.resize(pair.drawing, (COLUMN, COLUMN), interpolation=cv2.INTER_AREA)
    caption = np.full((CAPTION, COLUMN, 3), 255, np.uint8)
    (width, _), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_DUPLEX, 0.6, 1)
    origin = ((COLUMN - width) // 2, 23)
    cv2.putText(caption, text, origin, cv2.FONT_HERSHEY_DUPLEX, 0.6, (40, 40, 40), 1, cv2.LINE_AA)
    framed = cv2.copyMakeBorder(np.vstack([person, drawing]), 2, 2, 2, 2, cv2.BORDER_CONSTANT, value=(255, 255, 255))
    return np.vstack([cv2.resize(framed, (COLUMN, framed.shape[0])), caption]).astype(np.uint8)


if __name__ == "__main__":
    main()
