"""Operators kept on disk, so that a face that has been seen before opens at once.

The cache is a convenience: a folder that cannot be written, or a file in it that is not what it should be, costs the
time of building the operator again and nothing else.
"""

import contextlib
import hashlib
import os
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import platformdirs

from conf.face.deformation.rbf import Operator

_PREFIX = 2  # lambda, a float64, takes the place of two float32
_MAX_FILES = 16  # files; one of 20,000 vertices is 4 MB


def cache_folder() -> Path:
    """Return the folder of the user's cache that holds operators; it may not exist."""
    return Path(platformdirs.user_cache_dir("conf", appauthor=False)) / "operators"


def cache_key(*parts: object) -> str:
    """Return a name that changes with every part: arrays, bytes, or anything with a faithful repr."""
    digest = hashlib.sha256()
    for part in parts:
        if isinstance(part, np.ndarray):
            part = part.tobytes()
        data = part if isinstance(part, bytes) else repr(part).encode()
        digest.update(f"{len(data)};".encode())
        digest.update(data)
    return digest.hexdigest()


def cached_operator(key: str, shape: tuple[int, int], build: Callable[[], Operator], /) -> Operator:
    """Return the operator kept under the key, or build it and keep it."""
    path = cache_folder() / f"{key}.npy"
    kept = _read(path, shape)
    if kept is not None:
        return kept
    operator = build()
    _write(path, operator)
    return operator


def _read(path: Path, shape: tuple[int, int]) -> Operator | None:
    """Return what the file holds if it is one finite matrix of the shape, with its lambda in front."""
    numbers = shape[0] * shape[1] + _PREFIX
    try:
        if path.stat().st_size > 4 * numbers + 4096:
            return None
        with path.open("rb") as file, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of headers that only look old
            values = np.lib.format.read_array(file, allow_pickle=False)
    except (OSError, ValueError, MemoryError):
        return None
    if values.shape != (numbers,) or values.dtype != np.float32 or not np.isfinite(values[_PREFIX:]).all():
        return None
    smoothing = float(values[:_PREFIX].view(np.float64)[0])
    return Operator(values[_PREFIX:].reshape(shape), smoothing) if np.isfinite(smoothing) else None


def _write(path: Path, operator: Operator) -> None:
    temporary = path.with_suffix(f".{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with temporary.open("wb") as file:
            np.save(file, np.concatenate([np.array([operator.smoothing]).view(np.float32), operator.matrix.ravel()]))
        temporary.replace(path)  # never half a file under the name
        for old in sorted(path.parent.glob("*.npy"), key=lambda kept: kept.stat().st_mtime)[:-_MAX_FILES]:
            old.unlink()
    except OSError:
        with contextlib.suppress(OSError):
            temporary.unlink()
