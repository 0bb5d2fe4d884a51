"""Frames of a camera, or of a clip. They have timestamps, but are not delayed until they are due."""

import math
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.errors import CameraError

DEFAULT_FPS = 25.0  # of files without a frame rate, such as image sequences
MAX_FPS = 240.0
MAX_PAUSE_S = 5.0  # a longer step between two frames of a clip is an error of the file
CAMERA_SIZE = (640, 480)  # px: larger frames cost USB bandwidth and time, and the tracker uses 256 px of them

VideoCapture = cv2.VideoCapture
Opener = Callable[[Any], VideoCapture]  # of an index or a path


@dataclass(frozen=True)
class Frame:
    """An image and its time.

    pixels : (H, W, 3) uint8 BGR
    timestamp : seconds: of a camera on the machine's clock, of a clip from its start; never falls
    """

    pixels: NDArray[np.uint8]
    timestamp: float


class _CaptureSource:
    """An open capture whose first frame has been read.

    fps : frames per second, as far as known; size : width and height, px
    """

    def __init__(self, capture: VideoCapture, first: NDArray[np.uint8]) -> None:
        self._capture = capture
        self._first: NDArray[np.uint8] | None = first
        fps = capture.get(cv2.CAP_PROP_FPS)
        self.fps = fps if math.isfinite(fps) and 0 < fps <= MAX_FPS else DEFAULT_FPS
        self.size: tuple[int, int] = (first.shape[1], first.shape[0])

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._capture.release()

    def _next(self) -> NDArray[np.uint8] | None:
        pixels, self._first = self._first, None
        return pixels if pixels is not None else _read(self._capture)


class Camera(_CaptureSource):
    """A camera."""

    def __init__(
        self,
        name: str,
        capture: VideoCapture,
        first: NDArray[np.uint8],
        *,
        clock: Callable[[], float],
        reopen: Callable[[], VideoCapture],
    ) -> None:
        super().__init__(capture, first)
        self._name = name
        self._clock = clock
        self._reopen = reopen
        self._failed = False

    def read(self) -> Frame:
        """Wait for the next frame and return it. After a failure the camera is opened anew at the next call.

        Raises CameraError when the camera gives no frame.
        """
        if self._failed:
            self._capture.release()
            self._capture = self._reopen()
        pixels = self._next()
        self._failed = pixels is None
        if pixels is None:
            raise CameraError(f"{self._name} gives no frames any more: plug it in again")
        if pixels.shape[1::-1] != self.size:
            pixels = np.asarray(cv2.resize(pixels, self.size, interpolation=cv2.INTER_AREA), np.uint8)
        return Frame(pixels, self._clock())


class VideoFile(_CaptureSource):
    """A video file or an image sequence."""

    def __init__(
        self, capture: VideoCapture, first: NDArray[np.uint8], *, reopen: Callable[[], VideoCapture] | None
    ) -> None:
        """reopen : opens the clip again at its end; None plays it once"""
        super().__init__(capture, first)
        self._reopen = reopen
        self._start = 0.0  # added to the file's own time; grows with each loop
        self._last: float | None = None

    def read(self) -> Frame | None:
        """Return the next frame, or None at the end."""
        pixels = self._next()
        if pixels is None:
            pixels = self._rewind()
        if pixels is None:
            return None
        self._last = self._timestamp()
        return Frame(pixels, self._last)

    def _timestamp(self) -> float:
        """Return the time of the frame just read: the file's if plausible, else the last plus 1/fps."""
        file_time = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
        if self._last is None:
            self._start = -file_time if math.isfinite(file_time) else 0.0
            return 0.0
        timestamp = self._start + file_time
        if math.isfinite(timestamp) and 0 < timestamp - self._last <= MAX_PAUSE_S:
            return timestamp
        return self._last + 1 / self.fps

    def _rewind(self) -> NDArray[np.uint8] | None:
        """Open the clip again: seeking to the start is not exact in every container."""
        if self._reopen is None or self._last is None:
            return None
        self._capture.release()
        self._capture = self._reopen()
        pixels = _read(self._capture)
        file_time = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
        self._start = self._last + 1 / self.fps - (file_time if math.isfinite(file_time) else 0.0)
        return pixels


FrameSource = Camera | VideoFile


def open_camera(
    which: int | str, /, *, clock: Callable[[], float] = time.monotonic, opener: Opener = cv2.VideoCapture
) -> Camera:
    """Open a camera by index or by device path. Raises CameraError if it is missing or busy."""
    _silence_opencv()
    index = int(which) if isinstance(which, int) or which.isdigit() else None
    name = f"camera {which}"
    device = Path(f"/dev/video{index}" if index is not None else str(which))

    def reopen() -> VideoCapture:
        capture = opener(str(which) if index is None else index)
        if capture.isOpened():
            capture.set(cv2.CAP_PROP_FRAME_WIDTH, CAMERA_SIZE[0])  # the camera uses the nearest that it supports
            capture.set(cv2.CAP_PROP_FRAME_HEIGHT, CAMERA_SIZE[1])
            capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)  # the newest frame, not one that has waited
        return capture

    capture = reopen()
    first = _read(capture) if capture.isOpened() else None
    if first is not None:
        return Camera(name, capture, first, clock=clock, reopen=reopen)
    capture.release()
    if os.name == "posix" and not device.exists():
        raise CameraError(f"there is no {name}: plug one in, name another, or give a clip instead.")
    if os.name == "posix" and not os.access(device, os.R_OK | os.W_OK):
        raise CameraError(
            f"{name} may not be used by this account: add it to the group that owns {device} (often `video`)."
        )
    raise CameraError(f"{name} gives no image: close the program that is using it, or name another.")


def open_clip(path: Path | str, /, *, loop: bool = False, opener: Opener = cv2.VideoCapture) -> VideoFile:
    """Open a video file, or images named by a pattern such as `frames/%04d.png`. Raises CameraError.

    loop : start again at the end; timestamps continue
    """
    _silence_opencv()
    name = str(path)
    if "%" not in name and not Path(name).is_file():
        raise CameraError(
            f"there is no file {name}: check the path, or name images by a pattern such as frames/%04d.png."
        )
    capture = opener(name)
    first = _read(capture) if capture.isOpened() else None
    if first is None:
        capture.release()
        raise CameraError(f"{name} cannot be played: give a video that OpenCV can decode, as AVI, MP4, MPG or MOV.")
    return VideoFile(capture, first, reopen=(lambda: opener(name)) if loop else None)


def _read(capture: VideoCapture) -> NDArray[np.uint8] | None:
    try:
        success, pixels = capture.read()
    except cv2.error:
        return None
    return np.asarray(pixels, dtype=np.uint8) if success and pixels is not None else None


def _silence_opencv() -> None:
    """Keep what OpenCV and FFmpeg write past Python off the terminal: errors reach the user as CameraError."""
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
