"""Fixtures: the first second of the Carphone sequence, and a clip without a face."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from conf.output.video_writer import VideoWriter
from conf.sender.capture.clip import open_clip

SHORT = 24


@pytest.fixture(scope="session")
def short_clip(models: Path, carphone_clip: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The first SHORT frames of Carphone, at its 30 frames a second."""
    path = tmp_path_factory.mktemp("clips") / "short.avi"
    with open_clip(carphone_clip) as clip, VideoWriter(path, fps=30.0) as writer:
        for _ in range(SHORT):
            frame = clip.read()
            assert frame is not None
            # Motion JPEG harms small images.
            writer.write(np.asarray(cv2.resize(frame.pixels, None, fx=2, fy=2), np.uint8))
    return path


@pytest.fixture(scope="session")
def empty_clip(models: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three grey frames."""
    path = tmp_path_factory.mktemp("clips") / "empty.avi"
    with VideoWriter(path, fps=30.0) as writer:
        for _ in range(3):
            writer.write(np.full((240, 320, 3), 128, np.uint8))
    return path
