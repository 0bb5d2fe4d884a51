"""Whole calls between two processes with a real clip, real UDP and a recorded drawing, on one host and on two."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from uuid import uuid4

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker

CODE = "amber-canoe-tiger-7"
CALL_LENGTHS_S = 6.0, 20.0, 60.0
ENOUGH_FRAMES = 20  # tracked; a loaded machine drops frames before tracking and needs a longer call
ENVIRONMENT = os.environ | {"OPENBLAS_NUM_THREADS": "1"}

pytestmark = pytest.mark.slow


def conf(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "conf", *map(str, arguments)]


def call(
    clip: Path, film: Path, *, listen: str, prefixes: tuple[list[str], list[str]] = ([], [])
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Make a call long enough for this machine's load and return the --json figures of receiver and sender."""
    for seconds in CALL_LENGTHS_S:
        received, sent = call_for(seconds, clip, film, listen=listen, prefixes=prefixes)
        if sent["frames_tracked"] >= ENOUGH_FRAMES:
            break
    return received, sent


def call_for(
    seconds: float, clip: Path, film: Path, *, listen: str, prefixes: tuple[list[str], list[str]]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Make one call of a given length and return both sides' figures; prefixes precede their commands."""
    command = prefixes[0] + conf("receive", "--listen", listen, "--code", CODE, "--headless", film, "--json")
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT
    ) as receiver:
        try:
            assert receiver.stderr is not None and receiver.stdout is not None
            address = re.search(r"listening on (\S+),", receiver.stderr.readline())
            assert address, "the receiver prints the address it listens on"
            source = ("--file", clip, "--loop", "--seconds", seconds, "--json")
            sent = send(prefixes[1] + conf("send", address[1], "--code", CODE, *source))
            receiver.send_signal(signal.SIGINT)  # a user's Ctrl-C; the figures are printed and the recording kept
            output, errors = receiver.communicate(timeout=60)
            assert receiver.returncode == 0, errors
        finally:
            receiver.kill()
    return json.loads(output), sent


def send(command: list[str]) -> dict[str, Any]:
    """Run a sender and return its figures; try again while the receiver is still loading on a loaded machine."""
    for _ in range(4):
        sender = subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT, timeout=180, check=False)
        if "nobody answered" not in sender.stderr:
            break
    assert sender.returncode == 0, sender.stderr
    figures: dict[str, Any] = json.loads(sender.stdout)
    return figures


def check(received: dict[str, Any], sent: dict[str, Any], film: Path) -> None:
    assert sent["frames_tracked"] >= ENOUGH_FRAMES
    assert sent["frames_sent"] > sent["frames_tracked"] * 0.6
    assert received["frames_received"] >= sent["frames_sent"] - 2
    assert received["frames_lost"] == 0
    assert received["raw_bytes_per_frame"] == 193 * 144 * 3
    assert received["ratio"] > 150
    assert drawn_mouth_openings(film).std() > 0.02


def drawn_mouth_openings(film: Path) -> NDArray[np.float64]:
    """Track every sixth drawing: distance of the inner lips relative to the eye distance."""
    tracker = FaceTracker(fetch_models())
    capture = cv2.VideoCapture(str(film))
    openings = []
    for count in range(10_000):
        is_read, pixels = capture.read()
        if not is_read:
            break
        tracking = tracker.track(np.asarray(pixels, np.uint8)) if count % 6 == 0 else None
        if tracking is not None:
            points = tracking.landmarks
            openings.append(np.linalg.norm(points[13] - points[14]) / np.linalg.norm(points[33] - points[263]))
    assert len(openings) > 10, "the drawings show a face"
    return np.array(openings)


def test_a_call_between_two_processes(carphone_clip: Path, tmp_path: Path) -> None:
    film = tmp_path / "call.avi"
    received, sent = call(carphone_clip, film, listen="127.0.0.1:0")
    check(received, sent, film)


@pytest.fixture
def namespaces() -> Iterator[tuple[str, str]]:
    """Two network namespaces, 10.77.0.1 and 10.77.0.2, connected by a virtual cable."""
    if os.geteuid() != 0 or not shutil.which("ip"):
        pytest.skip("network namespaces need root and the program ip")
    names = f"conf-a-{uuid4().hex[:6]}", f"conf-b-{uuid4().hex[:6]}"
    ends = f"ca{uuid4().hex[:6]}", f"cb{uuid4().hex[:6]}"
    commands = [f"ip netns add {name}" for name in names]
    commands.append(f"ip link add {ends[0]} netns {names[0]} type veth peer name {ends[1]} netns {names[1]}")
    for number, (name, end) in enumerate(zip(names, ends, strict=True), start=1):
        commands += [
            f"ip -n {name} addr add 10.77.0.{number}/24 dev {end}",
            f"ip -n {name} link set {end} up",
            f"ip -n {name} link set lo up",
        ]
    try:
        for command in commands:
            if subprocess.run(command.split(), capture_output=True, check=False).returncode:
                pytest.skip(f"this machine does not allow `{command}`")
        yield names
    finally:
        for name in names:
            subprocess.run(["ip", "netns", "del", name], capture_output=True, check=False)


def test_a_call_between_two_hosts(carphone_clip: Path, tmp_path: Path, namespaces: tuple[str, str]) -> None:
    film = tmp_path / "call.avi"
    first, second = (["ip", "netns", "exec", name] for name in namespaces)
    received, sent = call(carphone_clip, film, listen="10.77.0.1:5005", prefixes=(first, second))
    check(received, sent, film)
