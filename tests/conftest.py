"""Settings for every test: strict floating point, and Hypothesis in a fast and a deep profile."""

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from conf.sender.tracking.model_files import fetch_demo_clip

os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # read once, by whoever opens the first clip

settings.register_profile("fast", max_examples=60, deadline=None, derandomize=True)
settings.register_profile(
    "deep", max_examples=5000, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "fast"))

SHARED = Path(__file__).resolve().parents[2] / "shared"


@pytest.fixture(autouse=True)
def _strict_floats() -> object:
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        yield


@pytest.fixture
def shared() -> Path:
    """The folder of clips and tracks that does not belong to the repository."""
    if not SHARED.is_dir():
        pytest.skip("the clips and tracks beside the repository are not here")
    return SHARED


@pytest.fixture(scope="session")
def demo_clip() -> Path:
    """The sample clip of `conf demo`, fetched the first time."""
    return fetch_demo_clip()


@pytest.fixture(scope="module")
def display() -> Iterator[str]:
    """A free X display of 1280x800; Xvfb chooses its number and writes it to a pipe."""
    if not (shutil.which("Xvfb") and shutil.which("xdotool")):
        if os.environ.get("CONF_REQUIRE_GL"):
            pytest.fail("Xvfb and xdotool are missing: apt install xvfb xdotool")
        pytest.skip("Xvfb and xdotool are not here")
    read_end, write_end = os.pipe()
    command = ["Xvfb", "-displayfd", str(write_end), "-screen", "0", "1280x800x24", "-nolisten", "tcp"]
    server = subprocess.Popen(command, pass_fds=[write_end], stderr=subprocess.DEVNULL)
    os.close(write_end)
    with os.fdopen(read_end) as pipe:
        number = pipe.readline().strip()
    yield f":{number}"
    server.terminate()
    server.wait()
