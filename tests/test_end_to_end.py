"""A whole call as users make it: two processes, a real clip, real UDP, and what the receiver drew."""

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from uuid import uuid4

import cv2
import numpy as np
import pytest

from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker

CODE = "amber-canoe-tiger-7"
CALL_S = 6.0


def conf(*arguments: str | Path) -> list[str]:
    return [sys.executable, "-m", "conf", *map(str, arguments)]


def call(clip: Path, film: Path, *, listen: str, prefixes: tuple[list[str], list[str]] = ([], [])) -> tuple[dict, dict]:
    """Make a call and return the figures of receiver and sender."""
    receiver_prefix, sender_prefix = prefixes
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    command = conf("receive", "--listen", listen, "--code", CODE, "--headless", film, "--seconds", CALL_S + 4, "--json")
    with subprocess.Popen(
        receiver_prefix + command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as receiver:
        assert receiver.stderr is not None and receiver.stdout is not None
        address = re.search(r"listening on (\S+),", receiver.stderr.readline())
        assert address, "the receiver says where it listens"
        sender = subprocess.run(
            sender_prefix
            + conf("send", address[1], "--code", CODE, "--file", clip, "--loop", "--seconds", CALL_S, "--json"),
            capture_output=True,
            text=True,
            env=environment,
            timeout=60,
            check=False,
        )
        assert sender.returncode == 0, sender.stderr
        output, errors = receiver.communicate(timeout=60)
        assert receiver.returncode == 0, errors
    return json.loads(output), json.loads(sender.stdout)


def check(received: dict, sent: dict, film: Path) -> None:
    assert sent["frames_tracked"] > CALL_S * 15 * 0.2  # a busy machine drops frames before it tracks them
    assert sent["frames_sent"] > sent["frames_tracked"] * 0.6
    assert received["frames_received"] >= sent["frames_sent"] - 2
    assert received["frames_lost"] == 0
    assert received["raw_bytes_per_frame"] == 176 * 144 * 3
    assert received["ratio"] > 150
    assert drawn_mouth_openings(film).std() > 0.02


def drawn_mouth_openings(film: Path) -> np.ndarray:
    """Track the drawing: inner lips apart, as a share of the eye distance."""
    tracker = FaceTracker(fetch_models())
    capture = cv2.VideoCapture(str(film))
    openings = []
    for count in range(10_000):
        there, pixels = capture.read()
        if not there:
            break
        tracking = tracker.track(pixels) if count % 6 == 0 else None
        if tracking is not None:
            at = tracking.landmarks
            openings.append(np.linalg.norm(at[13] - at[14]) / np.linalg.norm(at[33] - at[263]))
    assert len(openings) > 10, "the receiver has drawn a face"
    return np.array(openings)


def test_two_processes_on_loopback(demo_clip: Path, tmp_path: Path) -> None:
    film = tmp_path / "call.avi"
    received, sent = call(demo_clip, film, listen="127.0.0.1:0")
    check(received, sent, film)


@pytest.fixture
def namespaces() -> Iterator[tuple[str, str]]:
    """Two hosts of their own, 10.77.0.1 and 10.77.0.2, joined by a cable."""
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


def test_two_hosts(demo_clip: Path, tmp_path: Path, namespaces: tuple[str, str]) -> None:
    film = tmp_path / "call.avi"
    inside = tuple(["ip", "netns", "exec", name] for name in namespaces)
    received, sent = call(demo_clip, film, listen="10.77.0.1:5005", prefixes=(inside[0], inside[1]))
    check(received, sent, film)
