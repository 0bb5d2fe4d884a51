"""Cache of operators on disk, so that a known face opens at once.

If the folder cannot be written, or a file in it is damaged, the operator is built again.
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

_PREFIX = 2  # float32 values in front of the matrix that hold lambda, a float64
_MAX_FILES = 16  # one of 20,000 vertices has 4 MB


def cache_folder() -> Path:
    """Return the folder of cached operators; it may not exist."""
    return Path(platformdirs.user_cache_dir("conf", appauthor=False)) / "operators"


def cache_key(*parts: object) -> str:
    """Return the SHA-256 of the parts, in hex: arrays, bytes, or objects by their repr."""
    digest = hashlib.sha256()
    for part in parts:
        if isinstance(part, np.ndarray):
            part = part.tobytes()
        data = part if isinstance(part, bytes) else repr(part).encode()
        digest.update(f"{len(data)};".encode())
        digest.update(data)
    return digest.hexdigest()


def cached_operator(key: str, shape: tuple[int, int], build: Callable[[], Operator], /) -> Operator:
    """Return the operator cached under the key, or build and cache it. shape : (V, n)."""
    path = cache_folder() / f"{key}.npy"
    operator = _read(path, shape)
    if operator is None:
        operator = build()
        _write(path, operator)
    return operator


def _read(path: Path, shape: tuple[int, int]) -> Operator | None:
    """Return the operator in a file, or None if it is not a finite matrix of the shape with lambda in front."""
    numbers = shape[0] * shape[1] + _PREFIX
    try:
        if path.stat().st_size > 4 * numbers + 4096:
            return None
        with path.open("rb") as file, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # numpy warns of damaged headers as old ones
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
        temporary.replace(path)  # the file appears complete or not at all
        for old in sorted(path.parent.glob("*.npy"), key=lambda file: file.stat().st_mtime)[:-_MAX_FILES]:
            old.unlink()
    except OSError:
        with contextlib.suppress(OSError):
            temporary.unlink()
