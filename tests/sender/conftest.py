"""The tracker's files and clips, for the tests that need them."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.errors import ModelError
from conf.sender.capture.video import open_clip
from conf.sender.tracking.canonical_face import CanonicalFace, read_canonical_face
from conf.sender.tracking.model_files import fetch_demo_clip, fetch_models
from tests.support.short_clips import _models, empty_clip, short_clip

__all__ = ["_models", "empty_clip", "short_clip"]


@pytest.fixture(scope="session")
def models() -> Path:
    """The folder of the tracker's files."""
    try:
        return fetch_models()
    except ModelError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def canonical(models: Path) -> CanonicalFace:
    return read_canonical_face(models)


@pytest.fixture(scope="session")
def carphone() -> list[NDArray[np.uint8]]:
    """The first 20 pictures of the demo's clip."""
    try:
        path = fetch_demo_clip()
    except ModelError as error:
        pytest.skip(str(error))
    with open_clip(path) as clip:
        frames = [clip.read() for _ in range(20)]
    return [frame.pixels for frame in frames if frame is not None]
