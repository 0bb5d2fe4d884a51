"""Settings and fixtures of every test: floating point, Hypothesis profiles, OpenGL, model files, a display."""

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from conf.errors import ModelError
from conf.sender.tracking.model_files import fetch_models
from tests.support.opengl import gl, skip_or_fail
from tools.bench.carphone import fetch_carphone

__all__ = ["gl"]

os.environ["CONF_SETTINGS"] = os.devnull  # the settings of whoever runs the tests do not matter
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # silent; OpenCV reads it once, when it opens the first clip

settings.register_profile("fast", max_examples=60, deadline=None, derandomize=True)
settings.register_profile(
    "deep", max_examples=5000, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "fast"))

SHARED = Path(__file__).resolve().parents[2] / "shared"


@pytest.fixture(autouse=True)
def _strict_floats() -> Iterator[None]:
    """Raise FloatingPointError at division by zero, overflow and invalid operations of NumPy."""
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        yield


@pytest.fixture
def shared() -> Path:
    """The folder beside the repository that holds clips and tracks too large for it."""
    if not SHARED.is_dir():
        pytest.skip(f"the clips and tracks are not in {SHARED}")
    return SHARED


@pytest.fixture(scope="session")
def models() -> Path:
    """The folder of the tracker's files, fetched when they are missing."""
    try:
        return fetch_models()
    except ModelError as error:
        skip_or_fail(error)


@pytest.fixture(scope="session")
def carphone_clip() -> Path:
    """The Carphone sequence, a man talking in a car, fetched when it is missing."""
    try:
        return fetch_carphone()
    except ModelError as error:
        skip_or_fail(error)


@pytest.fixture(scope="module")
def display() -> Iterator[str]:
    """A new X display of 1280x800; Xvfb chooses its number and writes it to a pipe."""
    if not (shutil.which("Xvfb") and shutil.which("xdotool")):
        skip_or_fail("Xvfb and xdotool are missing: apt install xvfb xdotool")
    read_end, write_end = os.pipe()
    command = ["Xvfb", "-displayfd", str(write_end), "-screen", "0", "1280x800x24", "-nolisten", "tcp"]
    server = subprocess.Popen(command, pass_fds=[write_end], stderr=subprocess.DEVNULL)
    os.close(write_end)
    with os.fdopen(read_end) as pipe:
        number = pipe.readline().strip()
    yield f":{number}"
    server.terminate()
    server.wait()
