from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import cv2
import numpy as np
import pytest

from conf.face.animation.action_units import load_emotions
from conf.face.animation.timed_expression import blend_without_doubling
from conf.face.formats.dpc import DpcWriter, read_dpc
from conf.protocol.messages import MotionFrame
from conf.protocol.motion.inbound import ReceivedFrame
from conf.receiver.viewer_controls import KEYS, TOAST_S, ViewerControls, action_of, apply_view_event, help_lines
from conf.render.camera import TOGGLES, ViewState
from conf.render.window.input_events import Dragged, Event, KeyPressed, Scrolled
from conf.render.window.offscreen import OffscreenWindow
from conf.sender.capture.clip import open_clip


def press(
    monkeypatch: pytest.MonkeyPatch, viewer: ViewerControls, window: OffscreenWindow, *events: Event | str
) -> None:
    """Process key presses, by the keys' names, and other events at time 0."""
    pressed = [KeyPressed(event) if isinstance(event, str) else event for event in events]
    monkeypatch.setattr(window, "poll", lambda: pressed)
    viewer.process_events(0.0)


def paint(window: OffscreenWindow, shade: float) -> None:
    window.begin()
    window.framebuffer.clear(shade, shade, shade)
    window.end()


def test_keys_and_mouse_change_the_state(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    viewer = ViewerControls(window, tmp_path)
    assert not viewer.view.stats, "one line until M opens the statistics"
    press(monkeypatch, viewer, window, "space", "w", "m", Dragged("orbit", 0.1, 0.0))
    assert viewer.paused and viewer.view.wireframe and viewer.view.stats and viewer.view.yaw > 0
    press(monkeypatch, viewer, window, "m")
    assert not viewer.view.stats
    press(monkeypatch, viewer, window, "space")
    assert not viewer.paused and not viewer.quit_requested
    press(monkeypatch, viewer, window, "escape")
    assert viewer.quit_requested


def test_wireframe_and_points_say_that_a_photo_has_none(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow
) -> None:
    viewer = ViewerControls(window)
    press(monkeypatch, viewer, window, "w")
    assert viewer.toast(0.0) == ""
    viewer.shows_photo = True
    press(monkeypatch, viewer, window, "w")
    assert viewer.toast(0.0) == "", "switched off"
    press(monkeypatch, viewer, window, "w")
    assert viewer.toast(0.0) == "the photo has no wireframe: V shows the head"
    press(monkeypatch, viewer, window, "p")
    assert viewer.toast(0.0) == "the photo has no control points: V shows the head"


def test_a_number_key_adds_an_emotion_to_the_motion(monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow) -> None:
    viewer = ViewerControls(window)
    press(monkeypatch, viewer, window, "2")
    frame = MotionFrame(0.0, np.zeros((50, 3), np.float32), np.zeros(6))
    assert np.abs(viewer.add_emotions(frame, 1.0).displacements).max() > 100
    assert viewer.toast(0.0) == "surprise"
    assert viewer.add_emotions(frame, 20.0) is frame


def test_an_emotion_is_blended_with_the_motion_and_fades_out_the_one_before(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow
) -> None:
    viewer, emotions = ViewerControls(window), load_emotions()
    motion = np.random.default_rng(1).normal(0.0, 20.0, (50, 3)).astype(np.float32)
    frame = MotionFrame(0.0, motion, np.zeros(6))
    for key in "123456":
        press(monkeypatch, viewer, window, key)
        assert viewer.toast(0.0) == emotions.names[int(key) - 1]
    shown = viewer.add_emotions(frame, 1.0)
    np.testing.assert_allclose(
        shown.displacements, blend_without_doubling(motion, emotions.displacements[-1]), atol=1e-3
    )
    assert shown.pose is frame.pose


def test_a_toast_disappears_after_its_time(window: OffscreenWindow) -> None:
    viewer = ViewerControls(window)
    assert viewer.toast(0.0) == ""
    viewer.show_toast("hello", 1.0)
    assert viewer.toast(1.0 + TOAST_S - 0.01) == "hello"
    assert viewer.toast(1.0 + TOAST_S) == ""


def test_the_frame_drawn_after_the_key_is_saved(
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
    assert path.name == "conf-001.jpg" and viewer.toast(0.0) == f"saved {path}"
    assert np.abs(np.asarray(cv2.imread(str(path)), int) - 128).max() < 4


def test_a_video_plays_at_the_speed_of_the_call(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    """With 7 frames a second at uneven times, a second of the call is a second of the video."""
    viewer = ViewerControls(window, tmp_path)
    press(monkeypatch, viewer, window, "r")
    times = [0.0, 0.1, 0.3, 0.31, 0.6, 0.9, 1.0]
    for now in times:
        paint(window, now)
        viewer.on_frame_drawn(now)
    press(monkeypatch, viewer, window, "r")
    assert viewer.toast(0.0) == f"saved {tmp_path / 'conf-001.mp4'}"
    with open_clip(tmp_path / "conf-001.mp4") as clip:
        frames = {round(frame.timestamp, 3): frame.pixels.mean() for frame in iter(clip.read, None)}
    assert list(frames) == [0.0, 0.1, 0.3, 0.6, 0.9, 1.0]  # .31 is too soon after .3
    for now in (0.1, 0.6, 1.0):
        assert frames[now] == pytest.approx(255 * now, abs=4)
    assert viewer.reports == [f"saved {tmp_path / 'conf-001.mp4'}"]


def test_running_recordings_have_clocks(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    viewer = ViewerControls(window, tmp_path)
    viewer.has_callers = True
    assert viewer.recordings(0.0) == [] and not viewer.is_capturing
    press(monkeypatch, viewer, window, "r")
    assert viewer.recordings(7.5) == [("R", 7.5)] and viewer.is_capturing
    press(monkeypatch, viewer, window, "d")
    assert viewer.recordings(9.0) == [("R", 9.0), ("D", 9.0)]
    press(monkeypatch, viewer, window, "r")
    assert viewer.recordings(9.0) == [("D", 9.0)] and not viewer.is_capturing
    press(monkeypatch, viewer, window, "s", "d")
    assert viewer.recordings(9.0) == [] and viewer.is_capturing


def test_closing_completes_a_recording(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    viewer = ViewerControls(window, tmp_path)
    press(monkeypatch, viewer, window, "r")
    paint(window, 0.5)
    viewer.on_frame_drawn(0.0)
    viewer.close()
    viewer.close()
    assert [path.name for path in tmp_path.iterdir()] == ["conf-001.mp4"]
    assert viewer.reports == [f"saved {tmp_path / 'conf-001.mp4'}"]


def test_what_cannot_be_completed_when_the_window_closes_is_reported(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    viewer = ViewerControls(window, tmp_path)
    press(monkeypatch, viewer, window, "r")
    paint(window, 0.5)
    viewer.on_frame_drawn(0.0)
    monkeypatch.setattr("conf.output.video_writer.move_index_to_front", Mock(side_effect=OSError(28, "No space left")))
    monkeypatch.setattr(Path, "replace", Mock(side_effect=OSError(30, "Read-only file system")))
    viewer.close()
    (report,) = viewer.reports
    assert report.startswith(f"{tmp_path / 'conf-001.mp4'} cannot be written (Read-only file system)")


@pytest.mark.parametrize("key", ["s", "r"])
def test_an_unwritable_folder_shows_a_message_and_the_call_continues(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path, key: str
) -> None:
    viewer = ViewerControls(window, tmp_path / "nowhere")
    press(monkeypatch, viewer, window, key)
    paint(window, 0.5)
    viewer.on_frame_drawn(0.0)
    viewer.on_frame_drawn(0.1)
    assert "cannot be written (No such file or directory); choose another file or folder" in viewer.toast(0.1)
    viewer.close()


def test_a_full_disk_ends_the_recording_but_not_the_call(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    viewer = ViewerControls(window, tmp_path)
    press(monkeypatch, viewer, window, "r")
    paint(window, 0.5)
    viewer.on_frame_drawn(0.0)
    monkeypatch.setattr("conf.output.video_writer.DISK_CHECK_INTERVAL", 1)
    monkeypatch.setattr("conf.output.video_writer.shutil.disk_usage", lambda _: SimpleNamespace(free=1000))
    viewer.on_frame_drawn(2.0)
    path = tmp_path / "conf-001.mp4"
    full = f"{path}: the disk is full; free some space or choose another folder"
    assert viewer.toast(2.0) == f"{full}; saved {path}"
    assert path.exists()
    viewer.on_frame_drawn(2.1)
    press(monkeypatch, viewer, window, "r")
    viewer.on_frame_drawn(2.2)
    assert viewer.toast(2.2).endswith("choose another folder; nothing is saved")
    viewer.close()


def arrived(*numbers: int) -> list[ReceivedFrame]:
    return [
        ReceivedFrame(MotionFrame(number / 15, np.full((50, 3), number, np.float32), np.zeros(6)), 15)
        for number in numbers
    ]


def test_the_motion_that_arrives_is_recorded(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    viewer = ViewerControls(window, tmp_path)
    viewer.has_callers = True
    viewer.on_frames_received(1, arrived(0), 0.0)
    press(monkeypatch, viewer, window, "d", "1", "space")  # neither an emotion nor a pause changes what has arrived
    viewer.on_frames_received(1, arrived(1, 2), 0.1)
    viewer.on_frames_received(1, [], 0.2)
    viewer.on_frames_received(2, arrived(9), 0.3)
    press(monkeypatch, viewer, window, "d")
    first, second = (tmp_path / f"conf-00{number}.dpc" for number in (1, 2))
    assert viewer.toast(0.0) == f"saved {first} and {second}"
    assert viewer.reports == [f"saved {first}", f"saved {second}"]
    assert [float(frame[0, 0]) for frame in read_dpc(first).displacements] == [1, 2]
    assert [float(frame[0, 0]) for frame in read_dpc(second).displacements] == [9]


def test_without_a_call_no_recording_of_motion_starts(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    viewer = ViewerControls(window, tmp_path)
    press(monkeypatch, viewer, window, "d")
    assert viewer.toast(0.0) == "there is no call to record: press D again when someone has called"
    viewer.on_frames_received(1, arrived(1), 0.0)
    viewer.close()
    assert not list(tmp_path.iterdir()) and not viewer.reports


def test_a_recording_of_motion_without_a_frame_says_so(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    viewer = ViewerControls(window, tmp_path)
    viewer.has_callers = True
    press(monkeypatch, viewer, window, "d", "d")
    assert viewer.toast(0.0) == "no motion has arrived: nothing is saved"


def test_a_full_recording_of_motion_is_saved(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    monkeypatch.setattr("conf.output.motion_file.MAX_FRAMES", 3)
    viewer = ViewerControls(window, tmp_path)
    viewer.has_callers = True
    press(monkeypatch, viewer, window, "d")
    viewer.on_frames_received(1, arrived(1, 2, 3), 5.0)
    assert viewer.toast(5.0) == f"saved {tmp_path / 'conf-001.dpc'} after an hour; D starts again"
    viewer.on_frames_received(1, arrived(4), 5.1)
    assert viewer.reports == [f"saved {tmp_path / 'conf-001.dpc'}"]


def test_a_recording_of_motion_that_cannot_be_written_ends_and_keeps_what_was(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, tmp_path: Path
) -> None:
    viewer = ViewerControls(window, tmp_path)
    viewer.has_callers = True
    press(monkeypatch, viewer, window, "d")
    viewer.on_frames_received(1, arrived(*range(60)), 4.0)
    monkeypatch.setattr(DpcWriter, "write", Mock(side_effect=OSError(28, "No space left on device")))
    viewer.on_frames_received(1, arrived(*range(60, 90)), 6.0)
    path = tmp_path / "conf-001.dpc"
    reason = f"{path} cannot be written (No space left on device); choose another folder"
    assert viewer.toast(6.0) == f"{reason}; saved {path}" and viewer.reports == [f"saved {path}"]
    assert [float(frame[0, 0]) for frame in read_dpc(path).displacements] == list(range(16))
    assert not viewer.recordings(6.0)


@pytest.mark.parametrize("toggle", TOGGLES)
def test_every_switch_of_the_view_has_a_key(toggle: str) -> None:
    key = next(key for key, (action, _) in KEYS.items() if action == toggle)
    assert apply_view_event(ViewState(), KeyPressed(key)) == ViewState().toggled(toggle)


def test_zero_and_home_reset_the_camera_and_keep_the_switches() -> None:
    moved = ViewState(yaw=1.0, zoom=3.0, points=True)
    for key in ("0", "home"):
        assert apply_view_event(moved, KeyPressed(key)) == ViewState(points=True)


@pytest.mark.parametrize("key", ["x", "space"])
def test_other_keys_do_not_change_the_view(key: str) -> None:
    assert apply_view_event(ViewState(), KeyPressed(key)) == ViewState()


def test_the_mouse_moves_the_camera() -> None:
    assert apply_view_event(ViewState(), Dragged("orbit", 0.5, 0.0)) == ViewState().orbited(0.5, 0.0)


def test_only_bound_keys_have_actions() -> None:
    assert action_of(KeyPressed("space")) == "pause"
    assert action_of(KeyPressed("q")) == action_of(KeyPressed("escape")) == "quit"
    assert action_of(KeyPressed("")) is None
    assert action_of(Scrolled(1.0)) is None


def test_the_help_lists_every_key_and_the_mouse() -> None:
    lines = dict(help_lines())
    assert lines["Space"] == "pause and go on"
    assert lines["Esc, Q"] == "quit"
    assert lines["drag"] == "turn the head"
    listed = {key for keys in lines for key in keys.split(", ")}
    assert len(listed) == len(KEYS) + 3


def test_another_table_of_keys_and_an_owner_that_takes_events(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow
) -> None:
    taken: list[Event] = []

    def intercept(event: Event, now: float) -> bool:
        taken.append(event)
        return event == KeyPressed("q")

    keys = {"i": ("stats", "figures"), "q": ("quit", "hang up")}
    viewer = ViewerControls(window, keys=keys, intercept=intercept)
    press(monkeypatch, viewer, window, "m", "i", "q")
    assert viewer.view.stats and not viewer.quit_requested and len(taken) == 3
    assert help_lines(keys)[:2] == [("I", "figures"), ("Q", "hang up")]
    viewer.run_action("quit", 0.0)
    assert viewer.quit_requested and not viewer.is_recording
