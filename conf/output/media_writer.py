"""Write images and video. A file gets its final name when it is complete; after a crash a partial file remains."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Self, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.atomic_write import atomic_write, partial_path, report_write_errors
from conf.errors import RecordingError

JPEG_OPTIONS = [cv2.IMWRITE_JPEG_QUALITY, 93]
IMAGE_FORMATS: dict[str, list[int]] = {".jpg": JPEG_OPTIONS, ".jpeg": JPEG_OPTIONS, ".png": []}
VIDEO_FORMATS = {".avi": ("MJPG", cv2.CAP_OPENCV_MJPEG), ".mp4": ("mp4v", cv2.CAP_FFMPEG)}
MIN_FREE_BYTES = 16 << 20  # OpenCV does not report a full disk, so a video ends before that
DISK_CHECK_INTERVAL = 30  # frames

Format = TypeVar("Format")


def next_free_path(folder: Path, stem: str, suffix: str) -> Path:
    """Return the first of stem-001, stem-002, ... that does not exist."""
    number = 1
    while (path := folder / f"{stem}-{number:03d}{suffix}").exists():
        number += 1
    return path


def save_image(path: Path, pixels: NDArray[np.uint8]) -> Path:
    """Write (H, W, 3) uint8 BGR as JPG or PNG, according to the suffix. Returns the path.

    Raises RecordingError.
    """
    options = _format_of(path, IMAGE_FORMATS)
    is_encoded, data = cv2.imencode(path.suffix, pixels, options)
    if not is_encoded:
        raise RecordingError(f"{path}: this image cannot be encoded; choose another size or format")
    with report_write_errors(path, RecordingError), atomic_write(path) as partial:
        partial.write_bytes(data.tobytes())
    return path


class VideoWriter:
    """Writes an AVI (Motion JPEG) or MP4 (MPEG-4) file. All frames have the size of the first."""

    def __init__(self, path: Path, *, fps: float) -> None:
        """Raises RecordingError if the file cannot be created, ValueError if fps is not positive."""
        if not fps > 0:
            raise ValueError(f"fps must be positive, got {fps}")
        self.path = path
        self.frames = 0
        self._fps = fps
        self._format = _format_of(path, VIDEO_FORMATS)
        self._partial = partial_path(path)
        self._writer: cv2.VideoWriter | None = None
        self._size = (0, 0)
        self._began: float | None = None
        with report_write_errors(path, RecordingError):
            self._partial.touch()

    def write(self, pixels: NDArray[np.uint8]) -> None:
        """Add a frame, (H, W, 3) uint8 BGR; one of another size, after the window was resized, is scaled.

        Raises RecordingError when the disk is full.
        """
        if self.frames % DISK_CHECK_INTERVAL == 0 and shutil.disk_usage(self.path.parent).free < MIN_FREE_BYTES:
            raise RecordingError(f"{self.path}: the disk is full; free some space or choose another folder")
        if self._writer is None:
            self._size = (pixels.shape[1], pixels.shape[0])
            letters, backend = self._format
            fourcc = cv2.VideoWriter.fourcc(*letters)
            writer = cv2.VideoWriter(str(self._partial), backend, fourcc, self._fps, self._size)
            if not writer.isOpened():
                raise RecordingError(f"{self.path}: the clip cannot be opened for writing; choose another file or size")
            self._writer = writer
        if (pixels.shape[1], pixels.shape[0]) != self._size:
            pixels = np.asarray(cv2.resize(pixels, self._size, interpolation=cv2.INTER_AREA), np.uint8)
        self._writer.write(pixels)
        self.frames += 1

    def write_at(self, read: Callable[[], NDArray[np.uint8]], now: float) -> None:
        """Add the image shown at `now`, seconds, as often as the frame rate requires since the first call.

        read : returns the image; called only if it is needed
        """
        self._began = now if self._began is None else self._began
        due = int((now - self._began) * self._fps) + 1
        if self.frames < due:
            pixels = read()
            while self.frames < due:
                self.write(pixels)

    def close(self) -> Path | None:
        """Complete the file and give it its name. Returns the path, or None if there are no frames."""
        if self._writer is None:
            self._partial.unlink(missing_ok=True)
            return None
        self._writer.release()
        self._writer = None
        with report_write_errors(self.path, RecordingError):
            self._partial.replace(self.path)
        return self.path

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


def _format_of(path: Path, formats: dict[str, Format]) -> Format:
    found = formats.get(path.suffix.lower())
    if found is None:
        raise RecordingError(f"{path}: the name must end in {' or '.join(formats)}")
    return found
