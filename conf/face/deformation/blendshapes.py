"""Blendshapes of a head: vertex offsets for each of a set of expressions."""

import struct
import warnings
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError
from conf.face.formats.text import check_file

# What zipfile and numpy raise for a damaged archive.
READ_ERRORS = (
    *(
        AttributeError,
        EOFError,
        IndexError,
        KeyError,
        MemoryError,
        NotImplementedError,
        OSError,
        OverflowError,
        RuntimeError,
    ),
    *(TypeError, ValueError, struct.error, zipfile.BadZipFile, zlib.error),
)


@dataclass(frozen=True)
class Blendshapes:
    """Named expressions of one mesh.

    names : S of them
    offsets : (S, V, 3) float32 from the neutral vertices, model centimetres
    """

    names: tuple[str, ...]
    offsets: NDArray[np.float32]


def load_blendshapes(path: Path, vertex_count: int, /) -> Blendshapes:
    """Read the blendshapes of a mesh with vertex_count vertices from an .npz with `names` and `offsets`.

    Raises FileFormatError if the file does not hold them.
    """
    check_file(path)
    try:
        # numpy warns of damaged headers as old ones, and returns bytes for members that are no arrays
        with path.open("rb") as file, warnings.catch_warnings(action="ignore"), np.load(file) as arrays:
            offsets = arrays["offsets"].astype(np.float32)
            names = tuple(arrays["names"].reshape(-1).astype(str).tolist())
    except READ_ERRORS as error:
        raise FileFormatError(path, None, "expected blendshapes (`names`, `offsets`)") from error
    if offsets.shape != (len(names), vertex_count, 3) or not np.isfinite(offsets).all():
        expected = f"expected finite offsets of {vertex_count} vertices for each name, found shape {offsets.shape}"
        raise FileFormatError(path, None, expected)
    return Blendshapes(names, offsets)
