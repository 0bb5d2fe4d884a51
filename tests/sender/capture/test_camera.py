import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from conf.errors import CameraError
from conf.sender.capture.camera import CAMERA_SIZE, DEFAULT_FPS, Camera, open_camera

WIDTH, HEIGHT = 64, 48


def image(number: int) -> NDArray[np.uint8]:
    return np.full((HEIGHT, WIDTH, 3), 20 + 10 * number, np.uint8)


class FakeCapture:
    """Stands for a cv2.VideoCapture; gives `count` frames, then nothing."""

    def __init__(self, count: int, *, opens: bool = True, fps: float = 25.0) -> None:
        self.count, self.opens, self.fps = count, opens, fps
        self.index, self.released, self.settings = -1, False, dict[int, float]()

    def isOpened(self) -> bool:  # noqa: N802
        return self.opens

    def read(self) -> tuple[bool, NDArray[np.uint8] | None]:
        self.index += 1
        return (True, image(self.index)) if self.index < self.count else (False, None)

    def get(self, prop: int) -> float:
        return {cv2.CAP_PROP_FPS: self.fps}.get(prop, 0.0)

    def set(self, prop: int, value: float) -> bool:
        self.settings[prop] = value
        return True

    def release(self) -> None:
        self.released = True


def opener(capture: FakeCapture) -> Callable[[Any], Any]:
    """Return a function that opens the fake instead of a cv2.VideoCapture."""
    return lambda _: capture


def camera(capture: FakeCapture) -> Camera:
    ticks = iter(range(1000))
    return open_camera(3, clock=lambda: float(next(ticks)), opener=opener(capture))


def test_a_camera_gives_frames_with_the_machines_time() -> None:
    capture = FakeCapture(3)
    source = camera(capture)
    assert source.size == (WIDTH, HEIGHT)
    assert [source.read().timestamp for _ in range(3)] == [0.0, 1.0, 2.0]
    assert capture.settings[cv2.CAP_PROP_FRAME_WIDTH] == 640
    source.close()
    assert capture.released


def test_a_camera_that_is_unplugged_is_reported() -> None:
    source = camera(FakeCapture(2))
    source.read()
    source.read()
    with pytest.raises(CameraError) as caught:
        source.read()
    assert str(caught.value) == "camera 3 gives no images any more: plug it in again"


@pytest.mark.parametrize("which", [97, "97", "/dev/video97"])
def test_a_missing_camera_gives_one_message(which: int | str, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(CameraError) as caught:
        open_camera(which)
    assert str(caught.value) == f"there is no camera {which}: plug one in, name another, or give a clip instead."
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("capture", [FakeCapture(1, opens=False), FakeCapture(0)], ids=["closed", "silent"])
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
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may use anything
    with pytest.raises(CameraError) as caught:
        open_camera(str(device), opener=opener(FakeCapture(0, opens=False)))
    assert str(caught.value) == (
        f"camera {device} may not be used by this account: add it to the group that owns {device} (often `video`)."
    )


def test_a_camera_whose_name_is_not_utf8_is_reported() -> None:
    with pytest.raises(CameraError, match="has a name that is not UTF-8: name it by its number"):
        open_camera(os.fsdecode(b"/dev/vid\xefo0"))


def test_a_network_camera_that_does_not_answer_is_reported() -> None:
    with pytest.raises(CameraError, match=r"camera http://10\.0\.0\.9/ gives no image: check the address"):
        open_camera("http://10.0.0.9/", opener=opener(FakeCapture(0, opens=False)))


def test_a_camera_that_comes_back_is_opened_anew() -> None:
    captures = [FakeCapture(2), FakeCapture(0, opens=False), FakeCapture(3)]
    opened: Iterator[Any] = iter(captures)
    source = open_camera(3, clock=lambda: 1.0, opener=lambda _: next(opened))
    assert [source.read().pixels[0, 0, 0] for _ in range(2)] == [20, 30]
    for _ in range(2):
        with pytest.raises(CameraError, match="camera 3 gives no images any more: plug it in again"):
            source.read()
    assert [source.read().pixels[0, 0, 0] for _ in range(3)] == [20, 30, 40]
    assert captures[0].released and captures[1].released


def test_a_camera_that_was_released_is_opened_anew_with_a_fresh_image() -> None:
    captures = [FakeCapture(3), FakeCapture(3)]
    opened: Iterator[Any] = iter(captures)
    source = open_camera(3, clock=lambda: 0.0, opener=lambda _: next(opened))
    source.release()
    source.release()
    assert captures[0].released and not captures[1].settings
    assert source.read().pixels[0, 0, 0] == image(0)[0, 0, 0]
    assert captures[1].index == 0


def test_a_camera_that_changes_its_frame_size_keeps_the_first() -> None:
    capture = FakeCapture(3)
    source = open_camera(3, opener=opener(capture))
    source.read()
    capture.read = lambda: (True, np.zeros((2 * HEIGHT, 2 * WIDTH, 3), np.uint8))  # type: ignore[method-assign]
    assert source.read().pixels.shape == (HEIGHT, WIDTH, 3)


def test_a_camera_that_is_missing_may_come_later() -> None:
    captures = [FakeCapture(0, opens=False), FakeCapture(0, opens=False), FakeCapture(2)]
    opened: Iterator[Any] = iter(captures)
    source = open_camera("/dev/video97", clock=lambda: 1.0, opener=lambda _: next(opened), is_optional=True)
    assert source.size == CAMERA_SIZE and source.fps == DEFAULT_FPS
    with pytest.raises(CameraError, match="there is no camera /dev/video97: plug one in"):
        source.read()
    frame = source.read()
    assert frame.pixels.shape == (CAMERA_SIZE[1], CAMERA_SIZE[0], 3) and frame.pixels[0, 0, 0] == 20
    assert captures[0].released and captures[1].released


def test_an_image_of_another_shape_is_cropped_not_stretched() -> None:
    capture = FakeCapture(3)
    source = open_camera(3, opener=opener(capture))
    source.read()
    wide = np.zeros((HEIGHT, 2 * WIDTH, 3), np.uint8)
    wide[:, WIDTH // 2 : -WIDTH // 2] = 200
    capture.read = lambda: (True, wide)  # type: ignore[method-assign]
    assert (source.read().pixels == 200).all()


@pytest.mark.parametrize("fps", [0.0, -1.0, float("nan"), 90000.0])
def test_a_camera_without_a_frame_rate_gets_the_default(fps: float) -> None:
    assert open_camera(3, opener=opener(FakeCapture(1, fps=fps))).fps == DEFAULT_FPS
