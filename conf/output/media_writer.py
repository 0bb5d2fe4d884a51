"""Save what is drawn: pictures and clips. A file has its name only once it is whole; a crash leaves the partial one."""

import shutil
from pathlib import Path
from types import TracebackType
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.errors import RecordingError

JPEG_QUALITY = 93
PICTURES: dict[str, list[int]] = {
    ".jpg": [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY],
    ".jpeg": [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY],
    ".png": [],
}
CLIPS = {".avi": ("MJPG", cv2.CAP_OPENCV_MJPEG), ".mp4": ("mp4v", cv2.CAP_FFMPEG)}
MIN_FREE_BYTES = 16 << 20  # bytes: OpenCV does not say when it can write no more, so a clip ends before that
DISK_CHECK_INTERVAL = 30  # pictures

Kind = TypeVar("Kind")


def next_free_path(folder: Path, stem: str, suffix: str) -> Path:
    """Return the first of stem-001, stem-002, ... that is not taken yet."""
    number = 1
    while (path := folder / f"{stem}-{number:03d}{suffix}").exists():
        number += 1
    return path


def save_picture(path: Path, pixels: NDArray[np.uint8]) -> Path:
    """Write (H, W, 3) uint8 BGR as JPG or PNG, by the name's suffix. Returns the path.

    Raises RecordingError.
    """
    options = _codec_for(path, PICTURES)
    partial = _partial(path)
    done, data = cv2.imencode(path.suffix, pixels, options)
    if not done:
        raise RecordingError(f"{path}: this picture cannot be encoded; choose another size or format")
    try:
        partial.write_bytes(data.tobytes())
        partial.replace(path)
    except OSError as error:
        raise _cannot_write(path, error) from error
    return path


class VideoWriter:
    """Writes an AVI (Motion JPEG) or MP4 (MPEG-4) picture by picture. All pictures have the size of the first."""

    def __init__(self, path: Path, *, fps: float) -> None:
        """Raises RecordingError if the file cannot be made, ValueError if fps is not positive."""
        if not fps > 0:
            raise ValueError(f"fps must be positive, got {fps}")
        self.path = path
        self.frames = 0
        self._fps = fps
        self._codec = _codec_for(path, CLIPS)
        self._partial = _partial(path)
        self._writer: cv2.VideoWriter | None = None
        self._size = (0, 0)
        try:
            self._partial.touch()
        except OSError as error:
            raise _cannot_write(path, error) from error

    def write(self, pixels: NDArray[np.uint8]) -> None:
        """Add (H, W, 3) uint8 BGR; a picture of another size, after a resize, is scaled.

        Raises RecordingError when the disk is full.
        """
        if self.frames % DISK_CHECK_INTERVAL == 0 and shutil.disk_usage(self.path.parent).free < MIN_FREE_BYTES:
            raise RecordingError(f"{self.path}: the disk is full; free some space or choose another folder")
        if self._writer is None:
            self._writer = self._open((pixels.shape[1], pixels.shape[0]))
        if (pixels.shape[1], pixels.shape[0]) != self._size:
            pixels = np.asarray(cv2.resize(pixels, self._size, interpolation=cv2.INTER_AREA), np.uint8)
        self._writer.write(pixels)
        self.frames += 1

    def close(self) -> Path | None:
        """Finish the clip and give it its name. Returns the path, or None if nothing was recorded."""
        if self._writer is None:
            self._partial.unlink(missing_ok=True)
            return None
        self._writer.release()
        self._writer = None
        try:
            self._partial.replace(self.path)
        except OSError as error:
            raise _cannot_write(self.path, error) from error
        return self.path

    def __enter__(self) -> "VideoWriter":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _open(self, size: tuple[int, int]) -> cv2.VideoWriter:
        self._size = size
        letters, backend = self._codec
        fourcc = cv2.VideoWriter.fourcc(*letters)
        writer = cv2.VideoWriter(str(self._partial), backend, fourcc, self._fps, size)
        if not writer.isOpened():
            raise RecordingError(f"{self.path}: the clip cannot be opened for writing; choose another file or size")
        return writer


def _codec_for(path: Path, kinds: dict[str, Kind]) -> Kind:
    kind = kinds.get(path.suffix.lower())
    if kind is None:
        raise RecordingError(f"{path}: the name must end in {' or '.join(kinds)}")
    return kind


def _partial(path: Path) -> Path:
    return path.with_name(f"{path.stem}.partial{path.suffix}")


def _cannot_write(path: Path, error: OSError) -> RecordingError:
    return RecordingError(f"{path} cannot be written ({error.strerror}); choose another file or folder")
