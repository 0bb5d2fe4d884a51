"""Measure the CPU time of one end of a call with voice, without drawing, and compare it with the tracker's own.

    python tools/bench/call_cpu.py CLIP [--seconds 20] [--profile FILE] [--json]

Both ends run on this machine, each in a process of its own: camera (the clip), tracker, coding, encryption, sockets,
voice both ways, from a WAV file of the clip's sound, as a microphone needs no decoding, and to the null loudspeaker.
Nothing is drawn. CPU time is that of all threads of a process, after a warm-up. The tracker alone is measured in the
same run, on the frames of the same clip at 320x240 as in tools/bench/tracker.py; its share is its time for as many
frames a second as the call has tracked. To be reached: at most 2.5 times the tracker's share. --profile writes the
statistics of cProfile of the loop's thread.
"""

import argparse
import cProfile
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from conf.audio.devices import NULL_DEVICE, open_speaker
from conf.call.capture_thread import CaptureThread
from conf.call.controls import LocalState
from conf.call.loop import CallLoop, LocalEnd
from conf.call.self_view import SelfView
from conf.call.shared_objects import SharedObjectSender
from conf.commands.support.capture import CaptureOptions, open_source, rate_options, stream_parameters
from conf.output.wav_writer import write_wav
from conf.protocol.call_endpoint import CallEndpoint
from conf.receiver.voice.call_sound import LoudspeakerSound
from conf.receiver.voice.voice_mixer import VoiceMixer
from conf.sender.capture.clip import SOUND_RATE
from conf.sender.capture.sound import record_sound
from conf.sender.face_capture import FaceCapture
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker
from conf.transport.udp import UdpSocket
from tools.bench.tracker import read_images

ROOT = Path(__file__).resolve().parents[2]
CODE = "acorn-tulip-river-42"
WARM_UP_S = 4.0
LIMIT = 2.5
TRACKED_FRAMES = 200


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("clip", type=Path)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--profile", type=Path, help="write cProfile's statistics of the measured end")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--call", help=argparse.SUPPRESS)  # the other end, in a process of its own
    options = parser.parse_args()
    if options.call:
        host, port = options.call.rsplit(":", 1)
        hold(options.clip, options.seconds + WARM_UP_S + 5.0, remote=(host, int(port)))
        return
    figures = hold(options.clip, options.seconds, profile=options.profile)
    tracker_ms = tracker_cpu_ms(options.clip)
    tracker_share = tracker_ms / 1000 * figures["tracked_a_second"]
    result = {
        **figures,
        "tracker_cpu_ms": round(tracker_ms, 2),
        "tracker_share": round(tracker_share, 4),
        "times_tracker": round(figures["cpu_share"] / tracker_share, 2),
        "limit": LIMIT,
    }
    print(json.dumps(result) if options.json else "\n".join(f"{name:<20} {value}" for name, value in result.items()))


def tracker_cpu_ms(clip: Path) -> float:
    """Return the CPU time of the tracker for a frame, ms."""
    images, tracker = read_images(clip, TRACKED_FRAMES), FaceTracker(fetch_models())
    for image in images[:10]:
        tracker.track(image)
    began = time.process_time()
    for image in images:
        tracker.track(image)
    return (time.process_time() - began) / len(images) * 1000


def hold(
    clip: Path, seconds: float, *, remote: tuple[str, int] | None = None, profile: Path | None = None
) -> dict[str, Any]:
    """Hold one end of a call and return its figures. remote : whom to call; None waits for this program itself"""
    with ExitStack() as stack:
        socket = stack.enter_context(UdpSocket.open_to(*remote) if remote else UdpSocket.bind("127.0.0.1", 0))
        sound_file = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "sound.wav"
        write_wav(sound_file, record_sound(clip), rate=SOUND_RATE)
        capture_options = CaptureOptions(file=clip, loop=True, sound=sound_file)
        objects, self_view = SharedObjectSender(), SelfView()
        source, voice = stack.enter_context(open_source(capture_options, objects, lambda note: None))
        endpoint = CallEndpoint(
            code=CODE,
            parameters=stream_parameters(source),
            now=time.monotonic(),
            random=os.urandom,
            remote=socket.remote,
            rate=rate_options(capture_options, voice=True),
            portrait=objects,
        )
        mixer = VoiceMixer(endpoint.streams, np.random.default_rng(1))
        sound = stack.enter_context(LoudspeakerSound(mixer, open_speaker(NULL_DEVICE)))
        capture = FaceCapture(source, endpoint.outbound.profile.fps)
        thread = stack.enter_context(CaptureThread(capture))
        local = LocalEnd(thread, LocalState(), objects, self_view, voice)
        loop = CallLoop(endpoint, socket, local, sound=sound)
        if remote is None:
            stack.enter_context(start_other(clip, seconds, "{}:{}".format(*socket.address)))
        loop.run(should_continue=lambda: loop.connected_at is None)
        loop.run(seconds=WARM_UP_S)
        before = time.process_time(), time.monotonic(), capture.tracked, endpoint.report(time.monotonic())
        threads = thread_times()
        profiler = cProfile.Profile()
        if profile:
            profiler.enable()
        loop.run(seconds=seconds)
        if profile:
            profiler.disable()
            profiler.dump_stats(profile)
        spent = time.monotonic() - before[1]
        received = endpoint.report(time.monotonic()).frames_received - before[3].frames_received
        figures = {
            "cpu_share": round((time.process_time() - before[0]) / spent, 4),
            "tracked_a_second": round((capture.tracked - before[2]) / spent, 2),
            "received_a_second": round(received / spent, 2),
            "by_thread": {
                name: round((at - threads.get(name, 0.0)) / spent, 4) for name, at in sorted(thread_times().items())
            },
        }
        loop.close(time.monotonic())
        return figures


def thread_times() -> dict[str, float]:
    """Return the CPU seconds of each thread by name: the loop, capture, voice (the loudspeaker), and the libraries'."""
    names = {thread.native_id: thread.name for thread in threading.enumerate()}
    times: dict[str, float] = {}
    for task in Path("/proc/self/task").glob("*") if sys.platform == "linux" else ():
        fields = (task / "stat").read_text().rpartition(")")[2].split()
        name = names.get(int(task.name), "libraries").replace("MainThread", "loop")
        times[name] = times.get(name, 0.0) + (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return times


def start_other(clip: Path, seconds: float, address: str) -> subprocess.Popen[bytes]:
    """Start the other end in a process of its own."""
    command = [sys.executable, __file__, str(clip), "--seconds", str(seconds), "--call", address]
    return subprocess.Popen(command, env=os.environ | {"PYTHONPATH": str(ROOT)})


if __name__ == "__main__":
    main()
