from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from conf.face.formats.dpc import read_dpc
from conf.protocol.messages import MotionFrame
from conf.receiver.viewer_controls import CLIP_FPS, NOTICE_S, ConstantRateRecorder, ViewerControls
from conf.render.window.input_events import Dragged, Event, KeyPressed
from conf.render.window.offscreen import OffscreenWindow


def press(
    monkeypatch: pytest.MonkeyPatch, viewer: ViewerControls, window: OffscreenWindow, *events: Event | str
) -> None:
    """Let the viewer take keys, by their names, and other events, at time 0."""
    made = [KeyPressed(event) if isinstance(event, str) else event for event in events]
    monkeypatch.setattr(window, "poll", lambda: made)
    viewer.take_events(0.0)


def paint(window: OffscreenWindow, shade: float) -> None:
    window.begin()
    window.framebuffer.clear(shade, shade, shade)
    window.end()


def test_keys_and_mouse_do_what_the_help_says(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    viewer = ViewerControls(window, tmp_path)
    press(monkeypatch, viewer, window, "space", "w", "m", Dragged("turn", 0.1, 0.0))
    assert viewer.paused and viewer.view.wireframe and not viewer.view.meter and viewer.view.yaw > 0
    press(monkeypatch, viewer, window, "space")
    assert not viewer.paused and not viewer.quit_requested
    press(monkeypatch, viewer, window, "escape")
    assert viewer.quit_requested


def test_a_number_lays_an_emotion_over_the_motion(monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow) -> None:
    viewer = ViewerControls(window)
    press(monkeypatch, viewer, window, "2")
    frame = MotionFrame(0.0, np.zeros((50, 3), np.float32), np.zeros(6))
    assert np.abs(viewer.expressions.apply(frame, 1.0).displacements).max() > 100
    assert viewer.notice(0.0) == "surprise"


def test_a_notice_goes_by_itself(window: OffscreenWindow) -> None:
    viewer = ViewerControls(window)
    assert viewer.notice(0.0) == ""
    viewer.show_toast("hello", 1.0)
    assert viewer.notice(1.0 + NOTICE_S - 0.01) == "hello"
    assert viewer.notice(1.0 + NOTICE_S) == ""


def test_the_picture_saved_is_the_one_drawn_next(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    viewer = ViewerControls(window, tmp_path)
    press(monkeypatch, viewer, window, "s")
    assert not list(tmp_path.iterdir())
    paint(window, 0.5)
    viewer.on_frame_drawn(0.0)
    paint(window, 0.9)
    viewer.on_frame_drawn(0.1)
    (path,) = tmp_path.iterdir()
    assert path.name == "conf-001.jpg" and viewer.notice(0.0) == f"saved {path}"
    assert np.abs(np.asarray(cv2.imread(str(path)), int) - 128).max() < 4


def test_a_clip_plays_at_the_speed_of_what_was_seen(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    """Drawn at 7 pictures a second and at uneven times, a second of the call is a second of the clip."""
    viewer = ViewerControls(window, tmp_path)
    press(monkeypatch, viewer, window, "r")
    times = [0.0, 0.1, 0.3, 0.31, 0.6, 0.9, 1.0]
    for now in times:
        paint(window, now)
        viewer.on_frame_drawn(now)
    press(monkeypatch, viewer, window, "r")
    assert viewer.notice(0.0) == f"saved {tmp_path / 'conf-001.avi'}"
    capture = cv2.VideoCapture(str(tmp_path / "conf-001.avi"))
    frames = [capture.read()[1] for _ in range(int(capture.get(cv2.CAP_PROP_FRAME_COUNT)))]
    assert capture.get(cv2.CAP_PROP_FPS) == CLIP_FPS and len(frames) == CLIP_FPS + 1
    for now in (0.1, 0.6, 1.0):
        assert frames[round(now * CLIP_FPS)].mean() == pytest.approx(255 * now, abs=4)


def test_a_recording_under_way_is_whole_when_the_window_closes(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    viewer = ViewerControls(window, tmp_path)
    press(monkeypatch, viewer, window, "r")
    paint(window, 0.5)
    viewer.on_frame_drawn(0.0)
    viewer.close()
    viewer.close()
    assert [path.name for path in tmp_path.iterdir()] == ["conf-001.avi"]


@pytest.mark.parametrize("key", ["s", "r"])
def test_where_nothing_can_be_written_the_viewer_is_told_and_the_call_goes_on(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path, key: str
) -> None:
    viewer = ViewerControls(window, tmp_path / "nowhere")
    press(monkeypatch, viewer, window, key)
    paint(window, 0.5)
    viewer.on_frame_drawn(0.0)
    viewer.on_frame_drawn(0.1)
    assert "cannot be written (No such file or directory); choose another file or folder" in viewer.notice(0.1)
    viewer.close()


def test_a_disk_that_fills_up_ends_the_recording_and_not_the_call(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    viewer = ViewerControls(window, tmp_path)
    press(monkeypatch, viewer, window, "r")
    paint(window, 0.5)
    viewer.on_frame_drawn(0.0)
    monkeypatch.setattr("conf.output.media_writer.shutil.disk_usage", lambda _: SimpleNamespace(free=1000))
    viewer.on_frame_drawn(2.0)
    path = tmp_path / "conf-001.avi"
    full = f"{path}: the disk is full; free some space or choose another folder"
    assert viewer.notice(2.0) == f"{full}; saved {path}"
    assert path.exists()
    viewer.on_frame_drawn(2.1)
    press(monkeypatch, viewer, window, "r")
    viewer.on_frame_drawn(2.2)
    assert viewer.notice(2.2).endswith("choose another folder; saved nothing")
    viewer.close()


def test_an_empty_clip_leaves_no_file(tmp_path: Path) -> None:
    assert ConstantRateRecorder(tmp_path / "a.avi").close() is None
    assert not list(tmp_path.iterdir())


def test_the_motion_of_a_call_is_kept_as_a_recording(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    viewer = ViewerControls(window, tmp_path)
    frame = MotionFrame(0.0, np.full((50, 3), 7, np.float32), np.zeros(6))
    viewer.on_motion(frame, 0.0)
    press(monkeypatch, viewer, window, "d")
    for count in range(31):
        viewer.on_motion(frame, count / 30)
    press(monkeypatch, viewer, window, "d")
    (path,) = tmp_path.iterdir()
    assert viewer.notice(0.0) == f"saved {path}"
    assert (read_dpc(path).displacements == 7).all()
