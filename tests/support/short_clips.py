"""A second of the demo's clip, and a clip without a face."""

import os
from pathlib import Path

import cv2
import numpy as np
import pytest

from conf.errors import GraphicsError, ModelError
from conf.output.media_writer import VideoWriter
from conf.render.window.offscreen import OffscreenWindow
from conf.sender.capture.video import open_clip
from conf.sender.tracking.model_files import fetch_models

SHORT = 24


@pytest.fixture(scope="session")
def _models() -> None:
    try:
        fetch_models()
    except ModelError as error:
        if os.environ.get("CONF_REQUIRE_GL"):
            raise
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def short_clip(_models: None, demo_clip: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The first SHORT frames of the demo's clip, at its 30 frames a second."""
    path = tmp_path_factory.mktemp("clips") / "short.avi"
    with open_clip(demo_clip) as clip, VideoWriter(path, fps=30.0) as film:
        for _ in range(SHORT):
            frame = clip.read()
            assert frame is not None
            film.write(cv2.resize(frame.pixels, None, fx=2, fy=2))  # small pictures suffer from Motion JPEG
    return path


@pytest.fixture(scope="session")
def empty_clip(_models: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A few frames of grey."""
    path = tmp_path_factory.mktemp("clips") / "empty.avi"
    with VideoWriter(path, fps=30.0) as film:
        for _ in range(3):
            film.write(np.full((240, 320, 3), 128, np.uint8))
    return path


@pytest.fixture
def gl() -> None:
    """Skip without OpenGL, or fail when CONF_REQUIRE_GL says so."""
    try:
        OffscreenWindow(8, 8).release()
    except GraphicsError as error:
        if os.environ.get("CONF_REQUIRE_GL"):
            raise
        pytest.skip(str(error))
