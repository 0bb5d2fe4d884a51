"""The live picture: mirrored, newest first, with the reason where there is none."""

import threading
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.errors import CameraError
from conf.sender.capture.camera import Camera
from conf.sender.capture.frame import Frame
from conf.start.devices import device_thread
from conf.start.devices.camera_preview import MAX_SIZE, CameraPreview, mirrored

LIMIT_S = 20.0


class FakeCamera:
    """A camera that gives images until a number is reached and then waits, or fails."""

    fps = 1e6  # paces nothing

    def __init__(self, images: list[NDArray[np.uint8] | None]) -> None:
        self.images = images
        self.finished, self.closed = threading.Event(), threading.Event()

    def read(self) -> Frame:
        image = self.images.pop(0)
        if image is None:
            self.finished.set()
            raise CameraError("camera 0 gives no images any more: plug it in again")
        return Frame(image, 0.0)

    def __enter__(self) -> "FakeCamera":
        return self

    def __exit__(self, *_: object) -> None:
        self.closed.set()


def image(value: int) -> NDArray[np.uint8]:
    pixels = np.zeros((2, 4, 3), np.uint8)
    pixels[:, 0] = (value, 0, 9)  # BGR, the left column
    return pixels


def test_the_newest_image_is_kept_until_the_camera_fails() -> None:
    camera: Any = FakeCamera([image(1), image(2), None])
    opened: list[str] = []

    def opener(which: str) -> Camera:
        opened.append(which)
        return camera

    preview = CameraPreview("3", opener=opener)
    assert camera.finished.wait(LIMIT_S) and camera.closed.wait(LIMIT_S)
    count, newest = preview.newest()
    assert count == 2 and newest is not None and newest[0, -1].tolist() == [9, 0, 2, 255]
    preview.begin_close()
    assert preview.close() and opened == ["3"]
    assert preview.error == "camera 0 gives no images any more: plug it in again"


def test_a_camera_that_is_missing_is_an_error_and_no_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = threading.Event()

    def opener(which: str) -> Camera:
        if tried.is_set():
            again.set()
        tried.set()
        raise CameraError(f"there is no camera {which}")

    monkeypatch.setattr(device_thread, "RETRY_S", 0.0)
    again = threading.Event()
    preview = CameraPreview("9", opener=opener)
    assert again.wait(LIMIT_S)
    assert preview.error == "there is no camera 9" and preview.newest() == (0, None)
    assert preview.close()


def test_a_picture_is_mirrored_and_made_smaller() -> None:
    wide = np.zeros((300, 1920, 3), np.uint8)
    wide[:, :960] = (255, 0, 0)
    small = mirrored(wide)
    assert small.shape == (100, MAX_SIZE[0], 4)
    assert small[50, -1].tolist() == [0, 0, 255, 255] and small[50, 0].tolist() == [0, 0, 0, 255]
