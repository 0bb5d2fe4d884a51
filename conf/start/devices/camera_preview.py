"""The live picture of the camera that is chosen."""

from __future__ import annotations

import time
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.sender.capture.camera import Camera, open_camera
from conf.start.devices.device_thread import DeviceThread

MAX_SIZE = (640, 480)  # px, of the picture; it is drawn smaller


class CameraPreview:
    """An open camera and its newest image."""

    def __init__(self, which: str, *, opener: Callable[[str], Camera] = open_camera) -> None:
        """Open a camera in a thread. which : number, device or address"""
        self._which = which
        self._opener = opener
        self._image: NDArray[np.uint8] | None = None
        self._count = 0
        self._device = DeviceThread(self._use, name="camera preview")

    @property
    def error(self) -> str:
        """Return why there is no picture, "" if there is one or the camera is being opened."""
        return self._device.error

    def newest(self) -> tuple[int, NDArray[np.uint8] | None]:
        """Return the number of images so far and the last one, (H, W, 4) uint8 RGBA, mirrored as in a mirror."""
        return self._count, self._image

    def begin_close(self) -> None:
        """Tell the thread to release the camera, without waiting."""
        self._device.begin_close()

    def close(self) -> bool:
        """Release the camera. Returns False if its driver does not let go of it."""
        return self._device.close()

    def _use(self, thread: DeviceThread) -> None:
        self._image = None
        with self._opener(self._which) as camera:
            due = time.monotonic()
            while not thread.wait(max(0.0, due - time.monotonic())):
                due = time.monotonic() + 0.8 / camera.fps  # a camera waits for its frames, a clip in its place does not
                self._image = mirrored(camera.read().pixels)
                thread.error = ""
                self._count += 1


def mirrored(pixels: NDArray[np.uint8], /) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8 BGR as RGBA, left and right exchanged, no larger than MAX_SIZE."""
    height, width = pixels.shape[:2]
    scale = min(1.0, MAX_SIZE[0] / width, MAX_SIZE[1] / height)
    if scale < 1.0:
        size = max(1, round(width * scale)), max(1, round(height * scale))
        pixels = np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), np.uint8)
    return np.ascontiguousarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGBA)[:, ::-1])
