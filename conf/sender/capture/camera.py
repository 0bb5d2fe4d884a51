"""Frames of a camera, by OpenCV."""

import math
import os
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.errors import CameraError
from conf.sender.capture.frame import Frame

DEFAULT_FPS = 25.0  # of cameras that do not tell theirs
MAX_FPS = 240.0
CAMERA_SIZE = (640, 480)  # px: larger frames cost USB bandwidth and time, and the tracker uses 256 px of them

VideoCapture = cv2.VideoCapture
Opener = Callable[[Any], VideoCapture]  # of an index or a path


class Camera:
    """A camera.

    fps : frames per second, as far as known; size : width and height, px
    """

    is_live = True

    def __init__(
        self, which: int | str, *, clock: Callable[[], float], opener: Opener, is_optional: bool = False
    ) -> None:
        """Use `open_camera` instead."""
        self._index = int(which) if isinstance(which, int) or which.isdigit() else None
        self._which = which
        self._name = f"camera {which}"
        self._clock = clock
        self._opener = opener
        self._capture = self._open()
        self._first = self._read()
        self._failed = self._first is None
        self._has_worked = not self._failed
        self.fps, self.size = DEFAULT_FPS, CAMERA_SIZE
        if self._first is None:
            self._capture.release()
            if not is_optional:
                raise CameraError(self._why_not())
            return
        fps = self._capture.get(cv2.CAP_PROP_FPS)
        self.fps = fps if math.isfinite(fps) and 0 < fps <= MAX_FPS else DEFAULT_FPS
        self.size = (self._first.shape[1], self._first.shape[0])

    def read(self) -> Frame:
        """Wait for the next frame and return it. After a failure the camera is opened anew at the next call.

        Raises CameraError when the camera gives no frame.
        """
        if self._failed:
            self._capture.release()
            self._capture = self._open()
        pixels, self._first = self._first, None
        if pixels is None:
            pixels = self._read()
        self._failed = pixels is None
        if pixels is None:
            raise CameraError(
                f"{self._name} gives no images any more: plug it in again" if self._has_worked else self._why_not()
            )
        self._has_worked = True
        return Frame(self._fit(pixels), self._clock())

    def release(self) -> None:
        """Release the device until the next read, which opens it anew."""
        self._capture.release()
        self._first, self._failed = None, True

    def close(self) -> None:
        """Release the device."""
        self._capture.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _open(self) -> VideoCapture:
        capture = self._opener(str(self._which) if self._index is None else self._index)
        if capture.isOpened():
            capture.set(cv2.CAP_PROP_FRAME_WIDTH, CAMERA_SIZE[0])  # the camera uses the nearest that it supports
            capture.set(cv2.CAP_PROP_FRAME_HEIGHT, CAMERA_SIZE[1])
            capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)  # the newest frame, not one that has waited
        return capture

    def _read(self) -> NDArray[np.uint8] | None:
        if not self._capture.isOpened():
            return None
        try:
            ok, pixels = self._capture.read()
        except cv2.error:
            return None
        if not ok or pixels is None or pixels.ndim != 3 or pixels.shape[2] != 3:
            return None
        return np.asarray(pixels, dtype=np.uint8)

    def _fit(self, pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return an image in the size of all others, without what lies beyond their aspect ratio."""
        height, width = pixels.shape[:2]
        if (width, height) == self.size:
            return pixels
        scale = min(width / self.size[0], height / self.size[1])
        kept = round(self.size[0] * scale), round(self.size[1] * scale)
        left, top = (width - kept[0]) // 2, (height - kept[1]) // 2
        middle = pixels[top : top + kept[1], left : left + kept[0]]
        return np.asarray(cv2.resize(middle, self.size, interpolation=cv2.INTER_AREA), np.uint8)

    def _why_not(self) -> str:
        """Return what to tell the user of a camera that gives no image at the start."""
        device = Path(f"/dev/video{self._index}" if self._index is not None else str(self._which))
        if "://" in str(self._which):
            return f"{self._name} gives no image: check the address, and that the camera there is on."
        if os.name == "posix" and not device.exists():
            return f"there is no {self._name}: plug one in, name another, or give a clip instead."
        if os.name == "posix" and not os.access(device, os.R_OK | os.W_OK):
            return (
                f"{self._name} may not be used by this account: add it to the group that owns {device} (often `video`)."
            )
        return f"{self._name} gives no image: close the program that is using it, or name another."


def open_camera(
    which: int | str,
    /,
    *,
    clock: Callable[[], float] = time.monotonic,
    opener: Opener = cv2.VideoCapture,
    is_optional: bool = False,
) -> Camera:
    """Open a camera by index, by device path or by the address of a network camera.

    is_optional : a camera that is missing or busy is no error before it is read, and is opened when it is there
    Raises CameraError if it is missing or busy.
    """
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # errors reach the user as exceptions
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        str(which).encode()
    except UnicodeEncodeError as error:  # it would end the process in OpenCV
        raise CameraError(f"camera {which} has a name that is not UTF-8: name it by its number.") from error
    return Camera(which, clock=clock, opener=opener, is_optional=is_optional)
