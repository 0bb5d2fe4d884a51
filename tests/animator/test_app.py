"""The animator's window, controlled by real clicks and keys on a virtual display."""

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from conf.animator.app import AnimatorApp
from conf.animator.face_document import FaceDocument
from conf.animator.gui.layout import REFERENCE_ASPECT
from conf.animator.gui.panels.reference_face import IMAGE_WIDTH, reference_clip_matrix
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.formats.dpc import MotionClip, write_dpc
from conf.face.formats.ppc import read_ppc, write_ppc
from conf.render.ui.rectangle import Rect
from conf.render.window.offscreen import OffscreenWindow
from tests.animator.conftest import FILE_OFFSET, FILE_SCALE

pytestmark = pytest.mark.slow

REPOSITORY = Path(__file__).resolve().parents[2]
LIMIT_S = 120.0
State = dict[str, Any]


class Session:
    """The process of animator_process.py, its keyboard and mouse. It reports its state once a frame."""

    def __init__(self, display: str, *arguments: str) -> None:
        self._env = os.environ | {"DISPLAY": display, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        command = [sys.executable, "-W", "error", "-m", "tests.support.animator_process", *arguments]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, cwd=REPOSITORY, env=self._env, stdin=pipe, stdout=pipe, text=True)
        self._watchdog = threading.Timer(LIMIT_S, self.process.kill)
        self._watchdog.start()
        self.poll(2)
        name = ("--name", "conf animator test")
        self.xdotool("search", "--sync", *name, "windowfocus", "--sync", "windowmove", "0", "0")

    def xdotool(self, *command: object) -> None:
        subprocess.run(["xdotool", *map(str, command)], env=self._env, check=True, capture_output=True, timeout=LIMIT_S)

    def poll(self, frames: int = 1) -> State:
        """Return the state after this number of frames."""
        state: State = {}
        for _ in range(frames):
            assert self.process.stdin and self.process.stdout
            self.process.stdin.write("\n")
            self.process.stdin.flush()
            line = self.process.stdout.readline()
            assert line, "the animator has ended"
            state = json.loads(line)
        return state

    def wait_until(self, condition: Callable[[State], bool]) -> State:
        """Return the first state that fulfils the condition; the watchdog ends a wait that is too long."""
        while not condition(state := self.poll()):
            pass
        return state

    def click(self, x: float, y: float) -> State:
        self.xdotool("mousemove", round(x), round(y))
        self.poll(2)
        self.xdotool("mousedown", 1)
        self.poll(2)
        self.xdotool("mouseup", 1)
        return self.poll(3)

    def press(self, label: str, *, at: float = 0.5) -> State:
        """Click on a widget, at a fraction of its width."""
        left, top, right, bottom = self.poll()["widgets"][label]
        return self.click(left + at * (right - left), (top + bottom) / 2)

    def type(self, label: str, text: str) -> None:
        """Replace the text of a field."""
        self.press(label)
        self.xdotool("key", "ctrl+a")
        self.poll(4)
        self.xdotool("type", "--delay", "15", text)
        self.wait_until(lambda state: text in state["fields"])

    def key(self, name: str) -> State:
        self.xdotool("key", name)
        return self.poll(3)

    def close(self) -> int:
        """Quit with a key. Returns the exit code."""
        self.xdotool("key", "q")
        return self.process.wait(LIMIT_S)

    def kill(self) -> None:
        self._watchdog.cancel()
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe:
                pipe.close()


@pytest.fixture
def start(display: str, tmp_path: Path) -> Iterator[Callable[..., Session]]:
    sessions: list[Session] = []

    def starter(*arguments: str) -> Session:
        sessions.append(Session(display, str(tmp_path), *arguments))
        return sessions[-1]

    yield starter
    for session in sessions:
        session.kill()


def test_points_are_placed_by_clicks_corrected_by_dragging_and_saved(
    start: Callable[..., Session], unplaced_mesh: Path, points: np.ndarray, tmp_path: Path
) -> None:
    truth = points * FILE_SCALE + FILE_OFFSET
    session = start(str(unplaced_mesh))
    assert session.press("Place points ...")["placement"] == [0, 50]
    state = session.poll()
    rect = Rect(*state["rect"])
    pixels = to_pixels(truth, state)
    assert session.click(*pixels[0])["placement"] == [1, 49]
    brow = CONTROL_POINT_INDEX["brow_top_l"]
    assert session.click(*reference_pixel(session, points[brow]))["placement"] == [brow, 49]
    assert session.click(*pixels[brow])["placement"][1] == 47, "its partner is placed too"
    assert session.press("Undo")["placement"][1] == 49
    session.press("Cancel")
    assert session.press("Discard the points")["placement"] is None

    wrong = truth.copy()
    wrong[brow] += [0.0, 1.5 * FILE_SCALE, 0.0]
    write_ppc(tmp_path / "wrong.ppc", wrong)
    session.type("##PPC file", str(tmp_path / "wrong.ppc"))
    session.press("Load##PPC file")
    session.wait_until(lambda state: state["points"] is not None)
    session.press("Place points ...")
    state = session.press("also place the mirrored point")
    start_pixel, end_pixel = to_pixels(np.array([wrong[brow], truth[brow]]), state)
    assert rect.contains(*start_pixel) and rect.contains(*end_pixel)
    session.xdotool("mousemove", *map(round, start_pixel), "mousedown", 1)
    session.poll(2)
    for fraction in (0.3, 0.7, 1.0):
        session.xdotool("mousemove", *map(round, start_pixel + fraction * (end_pixel - start_pixel)))
        session.poll()
    session.xdotool("mouseup", 1)
    session.poll(2)
    assert session.press("OK")["placement"] is None
    session.type("##PPC file", str(tmp_path / "a.ppc"))
    session.press("Save PPC")
    session.wait_until(lambda state: "saved" in state["notice"])
    error_cm = np.linalg.norm(read_ppc(tmp_path / "a.ppc") - truth, axis=1) / FILE_SCALE
    assert np.delete(error_cm, brow).max() < 1e-4 and error_cm[brow] < 0.15
    session.press("joy")
    assert session.wait_until(lambda state: state["moved_cm"] > 0.8)
    assert session.close() == 0


def test_placed_points_are_not_lost_by_quitting(
    start: Callable[..., Session], unplaced_mesh: Path, points: np.ndarray
) -> None:
    session = start(str(unplaced_mesh))
    assert session.key("p")["notice"].startswith("this face has no control points yet")
    session.press("Place points ...")
    session.click(*to_pixels(points * FILE_SCALE + FILE_OFFSET, session.poll())[0])
    session.key("q")
    assert session.press("Do not quit")["placement"] == [1, 49]
    session.key("q")
    assert session.close() == 0, "Q again means it"


def test_closing_the_window_asks_too(document: FaceDocument, tmp_path: Path, gl: None) -> None:
    with OffscreenWindow(640, 480) as window:
        animator = AnimatorApp(window, document, tmp_path)
        animator.controller.place_points()
        placement = animator.controller.state.placement
        assert placement is not None
        animator.controller.state = replace(animator.controller.state, placement=placement.push_undo())
        closed = []
        for _ in range(2):
            window.should_close = True  # as the button of its frame does
            animator.draw_frame()
            closed.append(window.should_close)
        assert closed == [False, True]
        animator.close()


def to_pixels(file_positions: np.ndarray, state: State) -> np.ndarray:
    """Return the window pixels of positions in file coordinates."""
    scale, translation = state["file_to_model"]
    return Rect(*state["rect"]).to_pixels(file_positions * scale + np.array(translation), np.array(state["clip"]))


def reference_pixel(session: Session, point: np.ndarray) -> tuple[float, float]:
    """Return the window pixel of a point of the reference face."""
    left, top, right, bottom = session.poll()["widgets"]["reference"]
    clip = reference_clip_matrix((IMAGE_WIDTH, round(IMAGE_WIDTH * REFERENCE_ASPECT)))
    x, y = Rect(left, top, right - left, bottom - top).to_pixels(point[None], clip)[0]
    return float(x), float(y)


def test_a_recording_is_played_paused_stepped_and_exported(start: Callable[..., Session], tmp_path: Path) -> None:
    values = np.zeros((21, 50, 3), np.float32)
    values[:, 0, 1] = -300 * np.sin(np.linspace(0, np.pi, 21))
    write_dpc(tmp_path / "in.dpc", MotionClip(20.0, "fapu", values))
    session = start()
    session.type("##DPC file", str(tmp_path / "in.dpc"))
    session.xdotool("key", "Return")
    state = session.wait_until(lambda state: state["player"])
    assert state["player"][1] and state["player"][3]
    paused = session.press("Pause")["player"][0]
    assert session.poll(3)["player"] == [paused, False, 1.0, True]
    stepped = session.key("Right")["player"][0]
    assert stepped == pytest.approx(min(int(paused * 20) + 1, 20) / 20)
    assert session.press("##seek", at=0.5)["player"][0] == pytest.approx(0.5, abs=0.05)
    assert session.press("##speed", at=0.98)["player"][2] > 3
    assert session.key("space")["player"][1]
    assert session.press("Stop")["player"][:2] == [0.0, False]

    session.press("Export")
    session.type("##file", str(tmp_path / "out.mp4"))
    session.type("##size, px", "64x48")
    session.press("Export##button")
    session.wait_until(lambda state: "clips need a motion" in state["notice"])
    left, _, _, bottom = session.press("##source")["widgets"]["##source"]
    session.key("Escape")  # closes the open list, not the window
    session.click(left + 30, bottom + 34)  # the second line of the list
    assert session.poll(2)["source"] == "recording"
    session.press("Export##button")
    session.wait_until(lambda state: "out.mp4" in state["notice"])
    video = cv2.VideoCapture(str(tmp_path / "out.mp4"))
    assert video.get(cv2.CAP_PROP_FRAME_COUNT) == pytest.approx(31, abs=1) and video.read()[1].shape == (48, 64, 3)
    session.xdotool("key", "s")
    session.wait_until(lambda state: "conf-001.jpg" in state["notice"])
    assert np.asarray(cv2.imread(str(tmp_path / "conf-001.jpg"))).shape == (48, 64, 3)
    session.xdotool("key", "r")
    session.wait_until(lambda state: "recording the face as MP4" in state["notice"])
    session.poll(3)
    session.xdotool("key", "r")
    session.wait_until(lambda state: f"saved {tmp_path / 'conf-001.mp4'}" in state["notice"])
    assert cv2.VideoCapture(str(tmp_path / "conf-001.mp4")).read()[0]
    assert session.close() == 0


def test_kernels_and_muscles_change_while_the_face_moves(start: Callable[..., Session]) -> None:
    session = start()
    session.press("Deform")
    session.press("gaussian")
    state = session.wait_until(lambda state: not state["build"]["busy"])
    assert state["kernel"] == "gaussian"
    session.press("##locality, 1/cm", at=0.01)
    session.press("##lambda", at=0.01)
    session.wait_until(lambda state: not state["build"]["busy"] and state["build"]["smoothing"] > 0)
    session.press("Reset to defaults")
    session.press("Muscles")
    session.press("smile")
    state = session.wait_until(lambda state: state["moved_cm"] > 0.5)
    assert state["muscles"]
    session.press("surprise")
    assert not session.poll(2)["muscles"]
    session.xdotool("mousemove", 640, 300, "mousedown", 1)
    session.poll(2)
    session.xdotool("mousemove", 700, 300, "mouseup", 1)
    assert session.wait_until(lambda state: state["camera"]["yaw"] > 0.1)
    assert session.key("g")["style"] == "regions"
    assert session.close() == 0
