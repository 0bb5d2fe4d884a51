"""Start `conf` again in a process of its own."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import subprocess

PACKAGES = Path(__file__).parents[2]  # the folder that this very `conf` was imported from


def start_conf(arguments: Sequence[str], /, *, environment: Mapping[str, str] | None = None) -> subprocess.Popen[str]:
    """Start `conf` with arguments; the caller waits for it and ends it.

    environment : variables added to this process's own
    Its standard error is a pipe, and so is its standard output.
    """
    import subprocess

    # -P: a file conf.py in the working folder, as Sphinx has, would be run instead
    command = [sys.executable, "-P", "-m", "conf", *arguments]
    paths = [str(PACKAGES), *filter(None, [os.environ.get("PYTHONPATH")])]
    variables = os.environ | {"PYTHONPATH": os.pathsep.join(paths)} | dict(environment or {})
    return subprocess.Popen(
        command,
        env=variables,
        text=True,
        errors="replace",
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
