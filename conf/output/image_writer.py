"""Write images, and find free names for files."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.atomic_write import atomic_write, partial_path, report_write_errors
from conf.errors import RecordingError

JPEG_OPTIONS = [cv2.IMWRITE_JPEG_QUALITY, 93]
IMAGE_FORMATS: dict[str, list[int]] = {".jpg": JPEG_OPTIONS, ".jpeg": JPEG_OPTIONS, ".png": []}


def next_free_path(folder: Path, stem: str, suffix: str) -> Path:
    """Return the full path of the first of stem-001, stem-002, ... that neither exists nor is being written."""
    number = 1
    while (path := folder.absolute() / f"{stem}-{number:03d}{suffix}").exists() or partial_path(path).exists():
        number += 1
    return path


def save_image(path: Path, pixels: NDArray[np.uint8]) -> Path:
    """Write (H, W, 3) uint8 BGR as JPG or PNG, according to the suffix. Returns its full path.

    Raises RecordingError.
    """
    path = path.absolute()
    options = _format_of(path)
    is_encoded, data = cv2.imencode(path.suffix, pixels, options)
    if not is_encoded:
        raise RecordingError(f"{path}: this image cannot be encoded; choose another size or format")
    with report_write_errors(path, RecordingError), atomic_write(path) as partial:
        partial.write_bytes(data.tobytes())
    return path


def _format_of(path: Path) -> list[int]:
    found = IMAGE_FORMATS.get(path.suffix.lower())
    if found is None:
        raise RecordingError(f"{path}: the name of an image must end in {', '.join(IMAGE_FORMATS)}")
    return found
