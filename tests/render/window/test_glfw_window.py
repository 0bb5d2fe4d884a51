"""The window on a virtual display, in a process of its own, with simulated keyboard and mouse."""

import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import glfw
import numpy as np
import pytest

from conf.errors import GraphicsError
from conf.render.window.glfw_window import GlfwWindow
from tests.support.image_measures import Pixels, drawn

REPOSITORY = Path(__file__).resolve().parents[3]
LIMIT_S = 60.0


class Session:
    """The process of window_process.py, its keyboard and its mouse."""

    def __init__(self, display: str, image_path: Path) -> None:
        self.image_path = image_path
        self._env = os.environ | {"DISPLAY": display, "OPENBLAS_NUM_THREADS": "1"}
        command = [sys.executable, "-W", "error", "-m", "tests.support.window_process", str(image_path)]
        self.process = subprocess.Popen(command, cwd=REPOSITORY, env=self._env, stdout=subprocess.PIPE, text=True)
        self._watchdog = threading.Timer(LIMIT_S, self.process.kill)
        self._watchdog.start()
        self.wait_for_width(320)
        self.xdotool("search", "--sync", "--name", "conf test", "windowfocus", "--sync", "windowmove", "0", "0")

    def xdotool(self, *command: str) -> None:
        subprocess.run(["xdotool", *command], env=self._env, check=True, capture_output=True, timeout=LIMIT_S)

    def read_line(self) -> dict[str, Any]:
        assert self.process.stdout
        line = self.process.stdout.readline()
        assert line, "the process has ended"
        answer: dict[str, Any] = json.loads(line)
        return answer

    def read_event(self, kind: str) -> dict[str, Any]:
        while (answer := self.read_line()).get("event") != kind:
            pass
        return answer

    def wait_for_width(self, width: int) -> None:
        while self.read_line().get("size", [0])[0] != width:
            pass

    def key(self, name: str) -> dict[str, Any]:
        self.xdotool("key", name)
        return self.read_event("KeyPressed")

    def save_and_read_image(self) -> Pixels:
        self.xdotool("key", "s")
        while "saved" not in self.read_line():
            pass
        self.read_event("KeyPressed")
        return np.asarray(cv2.imread(str(self.image_path)), np.uint8)

    def close(self) -> int:
        self.xdotool("key", "q")
        assert self.process.stdout
        *_, last = self.process.stdout.read().splitlines()
        assert json.loads(last) == {"closed": True}
        code = self.process.wait()
        self.kill()
        return code

    def kill(self) -> None:
        self._watchdog.cancel()
        self.process.kill()
        self.process.wait()
        if self.process.stdout:
            self.process.stdout.close()


@pytest.fixture
def session(display: str, tmp_path: Path) -> Iterator[Session]:
    session = Session(display, tmp_path / "window.png")
    yield session
    session.kill()


@pytest.mark.slow
def test_keys_and_mouse_change_the_image(session: Session) -> None:
    before = session.save_and_read_image()
    assert before.shape == (240, 320, 3)
    assert 0.05 < drawn(before).mean() < 0.5

    assert session.key("w")["view"]["wireframe"]
    assert (np.abs(session.save_and_read_image().astype(int) - before).max(axis=2) > 40).mean() > 0.05
    session.key("w")

    session.xdotool("mousemove", "160", "120", "mousedown", "1", "mousemove", "200", "120", "mouseup", "1")
    orbited = session.read_event("Dragged")
    assert orbited["mode"] == "orbit" and orbited["view"]["yaw"] > 0
    assert session.key("Home")["view"]["yaw"] == 0

    session.xdotool("click", "4")
    assert session.read_event("Scrolled")["view"]["zoom"] > 1
    assert drawn(session.save_and_read_image()).sum() > drawn(before).sum()
    session.key("0")

    session.xdotool("keydown", "shift", "mousedown", "1", "mousemove", "200", "100", "mouseup", "1", "keyup", "shift")
    panned = session.read_event("Dragged")
    assert panned["mode"] == "pan" and panned["view"]["pan"][1] > 0
    session.key("0")

    assert session.key("h")["view"]["help"]
    assert (session.save_and_read_image() != before).any(axis=2).mean() > 0.2
    session.key("h")
    np.testing.assert_array_equal(session.save_and_read_image(), before)
    assert session.close() == 0


@pytest.mark.slow
def test_the_image_follows_the_window_size_and_full_screen(session: Session) -> None:
    session.xdotool("search", "--name", "conf test", "windowsize", "400", "300")
    session.wait_for_width(400)
    assert session.save_and_read_image().shape == (300, 400, 3)
    session.key("f")
    session.wait_for_width(1280)
    full = session.save_and_read_image()
    assert full.shape == (800, 1280, 3)
    assert 0.05 < drawn(full).mean() < 0.5
    session.xdotool("key", "f")
    session.wait_for_width(400)
    session.xdotool("key", "Escape")
    assert session.process.wait(LIMIT_S) == 0


def test_without_a_display_the_error_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(glfw, "init", lambda: False)
    with pytest.raises(GraphicsError, match=r"there is no display \(DISPLAY is not set\); run in a desktop session"):
        GlfwWindow(8, 8, "conf")


def test_a_size_that_is_not_positive_is_refused() -> None:
    with pytest.raises(ValueError, match="width and height must be positive"):
        GlfwWindow(0, 8, "conf")


HIDDEN_WINDOW = """
from conf.render.window.glfw_window import GlfwWindow
with GlfwWindow(300, 200, "conf hidden", min_size=(280, 190), visible=False) as window:
    window.clipboard = "höchst"
    states = [window.visible]
    for visible in (True, False):
        window.visible = visible
        window.poll()
        states.append(window.visible)
    print(states, window.clipboard)
"""


@pytest.mark.slow
def test_a_window_is_hidden_and_shown_and_has_the_clipboard(display: str) -> None:
    command = [sys.executable, "-W", "error", "-c", HIDDEN_WINDOW]
    environment = os.environ | {"DISPLAY": display, "PYTHONIOENCODING": "utf-8"}
    done = subprocess.run(command, cwd=REPOSITORY, env=environment, capture_output=True, text=True, timeout=LIMIT_S)
    assert done.stdout == "[False, True, False] höchst\n", done.stderr
