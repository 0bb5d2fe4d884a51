"""The real window, on a display of its own that nobody sees."""

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
    """The program of window_process.py, its keyboard and its mouse."""

    def __init__(self, display: str, picture: Path) -> None:
        self.picture = picture
        self._env = os.environ | {"DISPLAY": display, "OPENBLAS_NUM_THREADS": "1"}
        command = [sys.executable, "-W", "error", "-m", "tests.support.window_process", str(picture)]
        self.process = subprocess.Popen(command, cwd=REPOSITORY, env=self._env, stdout=subprocess.PIPE, text=True)
        self._watchdog = threading.Timer(LIMIT_S, self.process.kill)
        self._watchdog.start()
        self.size = self.hear()["ready"]
        self.do("search", "--sync", "--name", "conf test", "windowfocus", "--sync", "windowmove", "0", "0")

    def do(self, *command: str) -> None:
        subprocess.run(["xdotool", *command], env=self._env, check=True, capture_output=True, timeout=LIMIT_S)

    def hear(self) -> dict[str, Any]:
        assert self.process.stdout
        line = self.process.stdout.readline()
        assert line, "the window's program has ended"
        answer: dict[str, Any] = json.loads(line)
        return answer

    def hear_event(self, kind: str) -> dict[str, Any]:
        while (answer := self.hear()).get("event") != kind:
            pass
        return answer

    def key(self, name: str) -> dict[str, Any]:
        self.do("key", name)
        return self.hear_event("KeyPressed")

    def read_picture(self) -> Pixels:
        self.do("key", "s")
        while "saved" not in self.hear():
            pass
        self.hear_event("KeyPressed")
        return np.asarray(cv2.imread(str(self.picture)), np.uint8)

    def close(self) -> int:
        self.do("key", "q")
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


def test_keys_and_mouse_change_what_the_window_shows(session: Session) -> None:
    assert session.size == [320, 240]
    before = session.read_picture()
    assert 0.05 < drawn(before).mean() < 0.5

    assert session.key("w")["view"]["wireframe"]
    assert (np.abs(session.read_picture().astype(int) - before).max(axis=2) > 40).mean() > 0.05
    session.key("w")

    session.do("mousemove", "160", "120", "mousedown", "1", "mousemove", "200", "120", "mouseup", "1")
    turned = session.hear_event("Dragged")
    assert turned["mode"] == "turn" and turned["view"]["yaw"] > 0
    assert session.key("Home")["view"]["yaw"] == 0

    session.do("click", "4")
    assert session.hear_event("Scrolled")["view"]["zoom"] > 1
    assert drawn(session.read_picture()).sum() > drawn(before).sum()
    session.key("0")

    session.do("keydown", "shift", "mousedown", "1", "mousemove", "200", "100", "mouseup", "1", "keyup", "shift")
    panned = session.hear_event("Dragged")
    assert panned["mode"] == "pan" and panned["view"]["pan"][1] > 0
    session.key("0")

    assert session.key("h")["view"]["help"]
    assert (session.read_picture() != before).any(axis=2).mean() > 0.2
    session.key("h")
    np.testing.assert_array_equal(session.read_picture(), before)
    assert session.close() == 0


def test_the_picture_follows_the_windows_size_and_full_screen(session: Session) -> None:
    session.do("search", "--name", "conf test", "windowsize", "400", "300")
    while session.hear_event("Resized")["width"] != 400:
        pass
    assert session.read_picture().shape == (300, 400, 3)
    session.key("f")
    while session.hear_event("Resized")["width"] != 1280:
        pass
    full = session.read_picture()
    assert full.shape == (800, 1280, 3)
    assert 0.05 < drawn(full).mean() < 0.5
    session.do("key", "f")
    while session.hear_event("Resized")["width"] != 400:
        pass
    session.do("key", "Escape")
    assert session.process.wait(LIMIT_S) == 0


def test_without_a_display_one_sentence_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(glfw, "init", lambda: False)
    with pytest.raises(GraphicsError, match=r"there is no display \(DISPLAY is not set\); run in a desktop session"):
        GlfwWindow(8, 8, "conf")


def test_a_size_that_is_not_positive_is_refused() -> None:
    with pytest.raises(ValueError, match="width and height must be positive"):
        GlfwWindow(0, 8, "conf")
