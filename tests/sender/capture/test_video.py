from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from conf.errors import CameraError
from conf.sender.capture.video import DEFAULT_FPS, Camera, VideoFile, open_camera, open_clip

WIDTH, HEIGHT = 64, 48


def image(number: int) -> NDArray[np.uint8]:
    return np.full((HEIGHT, WIDTH, 3), 20 + 10 * number, np.uint8)


@pytest.fixture
def avi(tmp_path: Path) -> Path:
    """Five frames at 12.5 a second."""
    path = tmp_path / "clip.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 12.5, (WIDTH, HEIGHT))
    for number in range(5):
        writer.write(image(number))
    writer.release()
    return path


class FakeCapture:
    """Stands for a cv2.VideoCapture; gives frames at the given times, in seconds, then nothing."""

    def __init__(self, times: list[float], *, opens: bool = True, fps: float = 25.0) -> None:
        self.times, self.opens, self.fps = times, opens, fps
        self.index, self.released, self.settings = -1, False, dict[int, float]()

    def isOpened(self) -> bool:  # noqa: N802
        return self.opens

    def read(self) -> tuple[bool, NDArray[np.uint8] | None]:
        self.index += 1
        return (True, image(self.index)) if self.index < len(self.times) else (False, None)

    def get(self, prop: int) -> float:
        if prop == cv2.CAP_PROP_POS_MSEC:
            return self.times[min(self.index, len(self.times) - 1)] * 1000
        return self.fps

    def set(self, prop: int, value: float) -> bool:
        self.settings[prop] = value
        return True

    def release(self) -> None:
        self.released = True


def opener(capture: FakeCapture) -> Callable[[Any], Any]:
    """Return a function that opens the fake instead of a cv2.VideoCapture."""
    return lambda _: capture


def fake_clip(times: list[float], path: Path, *, fps: float = 25.0, loop: bool = False) -> VideoFile:
    path.write_bytes(b"")
    return open_clip(path, loop=loop, opener=opener(FakeCapture(times, fps=fps)))


def timestamps(clip: VideoFile, max_count: int = 100) -> list[float]:
    return [frame.timestamp for _ in range(max_count) if (frame := clip.read()) is not None]


def test_a_clip_gives_its_frames_with_its_own_timestamps(avi: Path) -> None:
    with open_clip(avi) as clip:
        assert (clip.size, clip.fps) == ((WIDTH, HEIGHT), 12.5)
        frames = [frame for _ in range(6) if (frame := clip.read())]
    assert [frame.timestamp for frame in frames] == pytest.approx([0, 0.08, 0.16, 0.24, 0.32])
    for number, frame in enumerate(frames):
        assert frame.pixels.shape == (HEIGHT, WIDTH, 3)
        assert frame.pixels.mean() == pytest.approx(20 + 10 * number, abs=2)


def test_a_clip_that_has_ended_gives_no_more_frames(avi: Path) -> None:
    with open_clip(avi) as clip:
        assert len(timestamps(clip)) == 5
        assert clip.read() is None


def test_a_looped_clip_has_rising_timestamps(avi: Path) -> None:
    with open_clip(avi, loop=True) as clip:
        frames = [frame for _ in range(13) if (frame := clip.read())]
    assert [frame.timestamp for frame in frames] == pytest.approx(np.arange(13) * 0.08)
    assert frames[7].pixels.mean() == pytest.approx(frames[2].pixels.mean(), abs=1)


def test_an_image_sequence_is_a_clip(tmp_path: Path) -> None:
    for number in range(4):
        cv2.imwrite(str(tmp_path / f"frame_{number:03d}.png"), image(number))
    with open_clip(tmp_path / "frame_%03d.png") as clip:
        frames = [frame for _ in range(9) if (frame := clip.read())]
    assert len(frames) == 4
    assert clip.fps > 0
    assert np.array_equal(frames[3].pixels, image(3))
    assert np.allclose(np.diff([frame.timestamp for frame in frames]), 1 / clip.fps)


@pytest.mark.parametrize("suffix", ["mp4", "mpg", "mov"])
def test_a_real_container_keeps_its_frame_rate(suffix: str, shared: Path) -> None:
    path = sorted((shared / "media").glob(f"*.{suffix}"))[0]
    with open_clip(path) as clip:
        times = timestamps(clip, 30)
    assert times[0] == 0
    assert np.all(np.diff(times) > 0)
    assert np.median(np.diff(times)) == pytest.approx(1 / clip.fps, rel=0.3)


def test_uneven_timestamps_of_a_file_are_kept(tmp_path: Path) -> None:
    assert timestamps(fake_clip([5.0, 5.01, 5.2, 5.25], tmp_path / "a")) == pytest.approx([0, 0.01, 0.2, 0.25])


@pytest.mark.parametrize(
    "times",
    [[0, 0, 0, 0], [0, -1, -2, -3], [0, 1000, 2000, 3000], [0, float("nan"), float("nan"), float("inf")]],
    ids=["none", "backwards", "leaps", "nonsense"],
)
def test_implausible_timestamps_are_replaced_by_the_frame_rate(tmp_path: Path, times: list[float]) -> None:
    with np.errstate(invalid="ignore"):
        assert timestamps(fake_clip(times, tmp_path / "a")) == pytest.approx([0, 0.04, 0.08, 0.12])


def test_timestamps_after_a_bad_one_are_used_again(tmp_path: Path) -> None:
    assert timestamps(fake_clip([0, 0.1, 0.0, 0.2, 0.3], tmp_path / "a")) == pytest.approx([0, 0.1, 0.14, 0.2, 0.3])


@pytest.mark.parametrize("fps", [0.0, -1.0, float("nan"), 90000.0])
def test_a_file_without_a_frame_rate_gets_the_default(tmp_path: Path, fps: float) -> None:
    clip = fake_clip([0, 0, 0], tmp_path / "a", fps=fps)
    assert clip.fps == DEFAULT_FPS
    assert timestamps(clip) == pytest.approx([0, 1 / DEFAULT_FPS, 2 / DEFAULT_FPS])


def test_a_loop_ends_when_its_file_is_gone(avi: Path) -> None:
    with open_clip(avi, loop=True) as clip:
        assert len(timestamps(clip, 4)) == 4
        avi.unlink()
        assert len(timestamps(clip, 10)) == 1


def test_a_missing_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(CameraError) as caught:
        open_clip(tmp_path / "none.avi")
    assert str(caught.value) == (
        f"there is no file {tmp_path / 'none.avi'}: "
        "check the path, or name images by a pattern such as frames/%04d.png."
    )


@pytest.mark.parametrize("name", ["text.avi", "empty.mp4", "none_%03d.png"])
def test_a_file_that_cannot_be_played_gives_one_message(
    tmp_path: Path, name: str, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / name
    if "%" not in name:
        path.write_text("this is not a video" if name == "text.avi" else "")
    with pytest.raises(CameraError) as caught:
        open_clip(path)
    assert (
        str(caught.value) == f"{path} cannot be played: give a video that OpenCV can decode, as AVI, MP4, MPG or MOV."
    )
    assert capfd.readouterr() == ("", "")  # neither OpenCV nor FFmpeg writes anything


def camera(capture: FakeCapture) -> Camera:
    ticks = iter(range(1000))
    return open_camera(3, clock=lambda: float(next(ticks)), opener=opener(capture))


def test_a_camera_gives_frames_with_the_machines_time() -> None:
    capture = FakeCapture([0, 0, 0])
    with camera(capture) as source:
        assert source.size == (WIDTH, HEIGHT)
        assert [source.read().timestamp for _ in range(3)] == [0.0, 1.0, 2.0]
        assert capture.settings[cv2.CAP_PROP_FRAME_WIDTH] == 640
    assert capture.released


def test_a_camera_that_is_unplugged_is_reported() -> None:
    source = camera(FakeCapture([0, 0]))
    source.read()
    source.read()
    with pytest.raises(CameraError) as caught:
        source.read()
    assert str(caught.value) == "camera 3 has stopped giving images: plug it in again and start anew."


@pytest.mark.parametrize("which", [97, "97", "/dev/video97"])
def test_a_missing_camera_gives_one_message(which: int | str, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(CameraError) as caught:
        open_camera(which)
    assert str(caught.value) == f"there is no camera {which}: plug one in, name another, or give a clip instead."
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("capture", [FakeCapture([0], opens=False), FakeCapture([])], ids=["closed", "silent"])
def test_a_busy_camera_is_reported(tmp_path: Path, capture: FakeCapture) -> None:
    device = tmp_path / "video0"
    device.write_text("")
    with pytest.raises(CameraError) as caught:
        open_camera(str(device), opener=opener(capture))
    assert str(caught.value) == (
        f"camera {device} gives no image: close the program that is using it, or name another."
    )
    assert capture.released


def test_a_camera_without_permission_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    device = tmp_path / "video0"
    device.write_text("")
    monkeypatch.setattr("os.access", lambda *_: False)  # root may use anything
    with pytest.raises(CameraError) as caught:
        open_camera(str(device), opener=opener(FakeCapture([], opens=False)))
    assert str(caught.value) == (
        f"camera {device} may not be used by this account: add it to the group that owns {device} (often `video`)."
    )
