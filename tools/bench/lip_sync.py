"""Measure lip sync on the clips that `conf receive --headless` writes: are lips and voice of one instant together?

Two processes call each other over loopback through a relay that loses datagrams. The written clip is tracked like any
other. The skew is the lag at which the inner lip opening of the face correlates best with the logarithm of the speech
energy of the clip's own sound, pooled over the clips: one clip of 3 s alone says little. ITU-R BT.1359-1: errors are
noticed from 45 ms early to 125 ms late.
"""

import contextlib
import os
import random
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Thread

import numpy as np
from numpy.typing import NDArray

from conf.audio.samples import SAMPLE_RATE
from conf.sender.capture.clip import read_sound
from conf.sender.tracking.offline import track_clip

ROOT = Path(__file__).resolve().parents[2]
CODE = "amber-canoe-tiger-7"
UPPER_LIP, LOWER_LIP, RIGHT_EYE, LEFT_EYE = 13, 14, 33, 263  # landmarks: inner lips, outer eye corners
LAGS_S = np.arange(-0.4, 0.401, 0.01)
ENERGY_S = 0.04  # window of the speech energy: a frame of a clip
START_S = 1.5  # of a call, in which it begins and the neutral face is found
MIN_FPS = 10.0  # of a clip, whose faces the tracker finds; fewer are drawn on a machine that is too busy
FLOOR = 1e-5  # power of full scale below which there is silence: -50 dB


@dataclass(frozen=True)
class LipSync:
    """What a clip shows and lets hear, sampled at its frames.

    opening : (N,) of the inner lips over the eye distance; energies : (N, len(LAGS_S)), log energy at each lag
    """

    opening: NDArray[np.float64]
    energies: NDArray[np.float64]


class LossyRelay:
    """Forwards datagrams between one caller and a receiver, and loses a fraction of them, both ways."""

    def __init__(self, loss: float, seed: int) -> None:
        self.receiver = ("127.0.0.1", 0)  # set before the call
        self._loss, self._random, self._stopped = loss, random.Random(seed), Event()
        self._near, self._far = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        self._near.bind(("127.0.0.1", 0))
        self._far.bind(("127.0.0.1", 0))
        self.port: int = self._near.getsockname()[1]
        self._thread = Thread(target=self._run, daemon=True)

    def __enter__(self) -> "LossyRelay":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stopped.set()
        self._thread.join()
        self._near.close()
        self._far.close()

    def _run(self) -> None:
        caller = None
        while not self._stopped.is_set():
            for ready in select.select([self._near, self._far], [], [], 0.1)[0]:
                data, address = ready.recvfrom(65536)
                if ready is self._near:
                    caller = address
                if self._random.random() < self._loss:
                    continue
                if ready is self._near:
                    self._far.sendto(data, self.receiver)
                elif caller:
                    self._near.sendto(data, caller)


def record_call(clip: Path, output: Path, *, kbps: float, loss: float, seconds: float, seed: int = 1) -> None:
    """Send a clip again and again, and write what is received. Raises RuntimeError if a process fails.

    seconds : of the sender, from when it calls
    """
    command = [sys.executable, "-m", "conf"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    receive = [*command, "receive", "--listen", "127.0.0.1:0", "--code", CODE, "--headless", str(output)]
    with (
        subprocess.Popen(receive, stdout=subprocess.PIPE, text=True, env=environment) as receiver,
        LossyRelay(loss, seed) as relay,
    ):
        assert receiver.stdout
        line = receiver.stdout.readline()  # listening on 127.0.0.1:PORT, code CODE
        relay.receiver = ("127.0.0.1", int(line.split(",")[0].rpartition(":")[2]))
        send = [*command, "send", f"127.0.0.1:{relay.port}", "--code", CODE, "--file", str(clip), "--loop"]
        send += ["--kbps", f"{kbps:g}", "--seconds", str(seconds)]
        sent = subprocess.run(send, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment)
        receiver.send_signal(signal.SIGINT)
        rest = receiver.stdout.read()
    if sent.returncode or receiver.returncode:
        raise RuntimeError(f"a call of {clip.name} failed: {sent.stdout} {rest}")


def read_lip_sync(clip: Path, *, seconds: float = float("inf")) -> LipSync:
    """Return lip opening and speech energy of the end of a clip, of so many seconds."""
    parts = list(read_sound(clip, rate=SAMPLE_RATE))
    begin = parts[0][0] if parts else 0.0
    sound = np.concatenate([samples for _, samples in parts]).astype(float) / 32768
    sums = np.concatenate([[0.0], np.cumsum(sound**2)])
    half = int(ENERGY_S / 2 * SAMPLE_RATE)
    openings, energies = [], []
    faces = [(frame.timestamp, face.landmarks) for frame, face in track_clip(clip) if face is not None]
    for timestamp, landmarks in faces:
        if timestamp < faces[-1][0] - seconds:
            continue
        lips = np.linalg.norm(landmarks[UPPER_LIP] - landmarks[LOWER_LIP])
        openings.append(lips / np.linalg.norm(landmarks[RIGHT_EYE] - landmarks[LEFT_EYE]))
        middles = np.clip(((timestamp - begin + LAGS_S) * SAMPLE_RATE).astype(int), half, len(sound) - half)
        energies.append(np.log((sums[middles + half] - sums[middles - half]) / (2 * half) + FLOOR))
    return LipSync(np.array(openings), np.array(energies).reshape(len(openings), len(LAGS_S)))


def pooled_skew(measured: Sequence[LipSync]) -> tuple[float, float]:
    """Return by how many ms the sound is early (+) or late (-), and the correlation there, over all clips together.

    Each clip counts relative to its own means, as mouths differ in size.
    """
    measured = [clip for clip in measured if len(clip.opening) > 1]
    opening = np.concatenate([clip.opening - clip.opening.mean() for clip in measured])
    energies = np.concatenate([clip.energies - clip.energies.mean(axis=0) for clip in measured])
    norms = np.linalg.norm(opening) * np.linalg.norm(energies, axis=0)
    scores = (opening @ energies) / np.maximum(norms, 1e-12)
    best = int(np.argmax(scores))
    return float(-1000 * LAGS_S[best]), float(scores[best])


def measure_skew(
    clips: Sequence[Path], folder: Path, *, kbps: float, loss: float, seconds: float
) -> tuple[float, float]:
    """Return the skew of calls with each of the clips, ms, and the correlation.

    A call that fails, or whose clip has too few frames, is made once more. Raises RuntimeError if it fails again.
    """
    measured = []
    for number, clip in enumerate(clips):
        output = folder / f"{clip.stem}_{kbps:g}_{loss:g}.mp4"

        def sync(clip: Path = clip, output: Path = output, seed: int = number) -> LipSync:
            record_call(clip, output, kbps=kbps, loss=loss, seconds=seconds, seed=seed)
            return read_lip_sync(output, seconds=seconds - START_S)

        with contextlib.suppress(RuntimeError):
            measured.append(sync())
        if len(measured) == number or len(measured[-1].opening) < MIN_FPS * (seconds - START_S):
            measured[number:] = [sync()]
    return pooled_skew(measured)
