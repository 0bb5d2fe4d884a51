"""The animator's window, worked by real clicks and keys on a display of its own that nobody sees."""

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from conf.animator.face_document import FaceDocument
from conf.animator.picking import Rect
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.formats.dpc import MotionClip, write_dpc
from conf.face.formats.ppc import read_ppc, write_ppc
from tests.animator.conftest import TO_FILE

REPOSITORY = Path(__file__).resolve().parents[2]
LIMIT_S = 120.0
Facts = dict[str, Any]


class Session:
    """The program of animator_process.py, its keyboard and its mouse. It answers once a frame."""

    def __init__(self, display: str, *arguments: str) -> None:
        self._env = os.environ | {"DISPLAY": display, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        command = [sys.executable, "-W", "error", "-m", "tests.support.animator_process", *arguments]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, cwd=REPOSITORY, env=self._env, stdin=pipe, stdout=pipe, text=True)
        self._watchdog = threading.Timer(LIMIT_S, self.process.kill)
        self._watchdog.start()
        self.ask(2)
        self.do("search", "--sync", "--name", "conf animator test", "windowfocus", "--sync", "windowmove", "0", "0")

    def do(self, *command: object) -> None:
        subprocess.run(["xdotool", *map(str, command)], env=self._env, check=True, capture_output=True, timeout=LIMIT_S)

    def ask(self, frames: int = 1) -> Facts:
        """Return how things stand, so many frames on."""
        facts: Facts = {}
        for _ in range(frames):
            assert self.process.stdin and self.process.stdout
            self.process.stdin.write("\n")
            self.process.stdin.flush()
            line = self.process.stdout.readline()
            assert line, "the animator has ended"
            facts = json.loads(line)
        return facts

    def until(self, wanted: Callable[[Facts], bool]) -> Facts:
        """Wait for it; the watchdog ends what never comes."""
        while not wanted(facts := self.ask()):
            pass
        return facts

    def click(self, x: float, y: float) -> Facts:
        self.do("mousemove", round(x), round(y))
        self.ask(2)
        self.do("mousedown", 1)
        self.ask(2)
        self.do("mouseup", 1)
        return self.ask(3)

    def press(self, label: str, *, along: float = 0.5) -> Facts:
        """Click on a widget, at a share of its width."""
        left, top, right, bottom = self.ask()["places"][label]
        return self.click(left + along * (right - left), (top + bottom) / 2)

    def type(self, label: str, text: str) -> None:
        self.press(label)
        self.do("key", "ctrl+a")
        self.ask(4)
        self.do("type", "--delay", "15", text)
        self.until(lambda now: text in now["fields"])

    def key(self, name: str) -> Facts:
        self.do("key", name)
        return self.ask(3)

    def close(self) -> int:
        self.do("key", "q")
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
    start: Callable[..., Session], stranger: Path, subject: FaceDocument, tmp_path: Path
) -> None:
    assert subject.points is not None
    scale, shift = TO_FILE
    truth = subject.points * scale + shift
    session = start(str(stranger))
    assert session.press("Place points ...")["placing"] == [0, 50]
    facts = session.ask()
    rect, clip = Rect(*facts["rect"]), np.array(facts["clip"])
    pixels = rect.to_pixels(truth * facts["scale"][0] + np.array(facts["scale"][1]), clip)
    assert session.click(*pixels[0])["placing"] == [1, 49]
    brow = CONTROL_POINT_INDEX["brow_top_l"]
    assert session.click(*reference_place(session, brow, subject))["placing"] == [brow, 49]
    assert session.click(*pixels[brow])["placing"][1] == 47, "its partner came along"
    assert session.press("Undo")["placing"][1] == 49
    assert session.press("Cancel")["placing"] is None

    wrong = truth.copy()
    wrong[brow] += [0.0, 1.5 * scale, 0.0]
    write_ppc(tmp_path / "wrong.ppc", wrong)
    session.type("##PPC file", str(tmp_path / "wrong.ppc"))
    session.press("Load##PPC file")
    facts = session.until(lambda now: now["points"] is not None)
    session.press("Place points ...")
    facts = session.press("a point takes its partner along")
    model = (np.array([wrong[brow], truth[brow]]) * facts["scale"][0]) + np.array(facts["scale"][1])
    taken, wanted = rect.to_pixels(model, np.array(facts["clip"]))
    session.do("mousemove", *map(round, taken), "mousedown", 1)
    session.ask(2)
    for share in (0.3, 0.7, 1.0):
        session.do("mousemove", *map(round, taken + share * (wanted - taken)))
        session.ask()
    session.do("mouseup", 1)
    session.ask(2)
    assert session.press("OK")["placing"] is None
    session.type("##PPC file", str(tmp_path / "a.ppc"))
    session.press("Save PPC")
    session.until(lambda now: "saved" in now["notice"])
    error = np.linalg.norm(read_ppc(tmp_path / "a.ppc") - truth, axis=1) / scale
    assert np.delete(error, brow).max() < 1e-4 and error[brow] < 0.15, "cm at an eye distance of 6.4 cm"
    session.press("joy")
    assert session.until(lambda now: now["moved_cm"] > 0.8)
    assert session.close() == 0


def reference_place(session: Session, point: int, subject: FaceDocument) -> tuple[float, float]:
    """Return where the reference face shows a point."""
    from conf.animator.gui.layout import REFERENCE
    from conf.animator.gui.panels.reference_face import SIDE, reference_clip_matrix

    left, top, right, bottom = session.ask()["places"]["reference"]
    assert subject.points is not None
    rect = Rect(left, top, right - left, bottom - top)
    x, y = rect.to_pixels(subject.points[[point]], reference_clip_matrix((SIDE, round(SIDE * REFERENCE))))[0]
    return float(x), float(y)


def test_a_recording_is_played_paused_stepped_and_exported(start: Callable[..., Session], tmp_path: Path) -> None:
    values = np.zeros((21, 50, 3), np.float32)
    values[:, 0, 1] = -300 * np.sin(np.linspace(0, np.pi, 21))
    write_dpc(tmp_path / "in.dpc", MotionClip(20.0, "fapu", values))
    session = start()
    session.type("##DPC file", str(tmp_path / "in.dpc"))
    session.do("key", "Return")
    facts = session.until(lambda now: now["player"])
    assert facts["player"][1] and facts["player"][3]
    paused = session.press("Pause")["player"][0]
    assert session.ask(3)["player"] == [paused, False, 1.0, True]
    stepped = session.key("Right")["player"][0]
    assert stepped == pytest.approx(min(int(paused * 20) + 1, 20) / 20)
    assert session.press("##seek", along=0.5)["player"][0] == pytest.approx(0.5, abs=0.05)
    assert session.press("##speed", along=0.98)["player"][2] > 3
    assert session.key("space")["player"][1]
    assert session.press("Stop")["player"][:2] == [0.0, False]

    session.press("Export")
    session.type("##file", str(tmp_path / "out.mp4"))
    session.type("##size, px", "64x48")
    session.press("Export##button")
    session.until(lambda now: "clips need a motion" in now["notice"])
    left, _, _, bottom = session.press("##source")["places"]["##source"]
    session.key("Escape")  # while a list is open it does not end the program
    session.click(left + 30, bottom + 34)  # the second line of the list
    assert session.ask(2)["source"] == "the recording"
    session.press("Export##button")
    session.until(lambda now: "out.mp4" in now["notice"])
    clip = cv2.VideoCapture(str(tmp_path / "out.mp4"))
    assert clip.get(cv2.CAP_PROP_FRAME_COUNT) == pytest.approx(31, abs=1) and clip.read()[1].shape == (48, 64, 3)
    session.do("key", "s")
    session.until(lambda now: "conf-001.jpg" in now["notice"])
    assert np.asarray(cv2.imread(str(tmp_path / "conf-001.jpg"))).shape == (48, 64, 3)
    assert session.close() == 0


def test_kernels_change_while_the_face_moves_and_muscles_take_over(start: Callable[..., Session]) -> None:
    session = start()
    session.press("Deform")
    session.press("gaussian")
    facts = session.until(lambda now: not now["built"][2])
    assert facts["kernel"] == "gaussian"
    session.press("##locality, 1/cm", along=0.01)
    session.press("##lambda", along=0.01)
    facts = session.until(lambda now: not now["built"][2] and now["built"][1] > 0)
    session.press("Back to the defaults")
    session.press("Muscles")
    session.press("smile")
    facts = session.until(lambda now: now["moved_cm"] > 0.5)
    assert facts["muscles"]
    session.press("surprise")
    assert not session.ask(2)["muscles"]
    session.do("mousemove", 640, 300, "mousedown", 1)
    session.ask(2)
    session.do("mousemove", 700, 300, "mouseup", 1)
    assert session.until(lambda now: now["view"]["yaw"] > 0.1)
    assert session.key("g")["style"] == "regions"
    assert session.close() == 0
