"""Read OBJ files.

trimesh reads OBJ too, but splits the file into one mesh per material, reorders and merges vertices, and drops the names
of groups. Here the order of the `v` lines is the vertex order of every array (operator, blendshapes), and the groups
tell which part is an eye or a tooth.
"""

from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError
from conf.face.formats.text import parse_floats, read_lines

MAX_VERTICES = 1_000_000
MAX_TRIANGLES = 2_000_000
DEFAULT_GROUP = "default"

# Keywords of the format that are not used; normals are computed for every frame.
_IGNORED = frozenset(
    b"vn vp s l p o mg usemtl lod usemap maplib shadow_obj trace_obj cstype deg bmat step curv curv2 surf parm trim"
    b" hole scrv sp end con bevel c_interp d_interp ctech stech call csh bsp bzp cdc cdp res".split()
)


@dataclass(frozen=True)
class RawMesh:
    """A mesh with separately indexed positions and texture coordinates, as in files.

    positions : (V, 3) float64, in the file's order
    uvs : (T, 2) float64
    corners : (F, 3, 2) int64, position index and texture coordinate index (-1: none) of each corner
    groups : name -> indices of its triangles
    texture : existing image file named by the material, or None
    """

    positions: NDArray[np.float64]
    uvs: NDArray[np.float64]
    corners: NDArray[np.int64]
    groups: dict[str, NDArray[np.int64]]
    texture: Path | None


def read_obj(path: Path, /) -> RawMesh:
    """Read positions, texture coordinates, polygons (as triangle fans) and groups.

    Raises FileFormatError, with the line number, for anything that is not OBJ.
    """
    text = _ObjText(path)
    for number, line in _joined_lines(path):
        words = line.split(b"#", 1)[0].split()
        if words:
            text.read(words, number)
    return text.result()


def _joined_lines(path: Path) -> Iterator[tuple[int, bytes]]:
    """Yield the lines; those that end in a backslash are joined with the next."""
    parts: list[bytes] = []
    for number, line in read_lines(path):
        if line.endswith(b"\\"):
            parts.append(line[:-1])
            if len(parts) > 100:
                raise FileFormatError(path, number, "expected at most 100 continued lines")
            continue
        yield number, b" ".join([*parts, line]) if parts else line
        parts.clear()


@dataclass
class _ObjText:
    """Parser state of one OBJ file; flat arrays need a tenth of the memory of lists."""

    path: Path
    positions: "array[float]" = field(default_factory=lambda: array("d"))  # three per vertex
    uvs: "array[float]" = field(default_factory=lambda: array("d"))  # two per texture coordinate
    corners: "array[int]" = field(default_factory=lambda: array("q"))  # six per triangle, as in RawMesh
    groups: dict[str, "array[int]"] = field(default_factory=dict)
    current: list[str] = field(default_factory=lambda: [DEFAULT_GROUP])
    library: str | None = None

    def read(self, words: list[bytes], number: int) -> None:
        reader = _KEYWORDS.get(words[0])
        if reader is not None:
            reader(self, words[1:], number)
        elif words[0] not in _IGNORED:
            raise FileFormatError(self.path, number, "expected an OBJ line such as `v x y z` or `f 1 2 3`")

    def read_position(self, words: list[bytes], number: int) -> None:
        if len(words) not in (3, 4, 6, 7):  # also with a weight, or with a colour, as some scanners write
            raise FileFormatError(self.path, number, "expected `v x y z`")
        self.positions.extend(parse_floats(words[:3], self.path, number, "expected `v x y z`"))
        if len(self.positions) > 3 * MAX_VERTICES:
            raise FileFormatError(self.path, number, f"expected at most {MAX_VERTICES} vertices")

    def read_uv(self, words: list[bytes], number: int) -> None:
        if not 1 <= len(words) <= 3:
            raise FileFormatError(self.path, number, "expected `vt u v`")
        self.uvs.extend([*parse_floats(words, self.path, number, "expected `vt u v`"), 0.0][:2])
        if len(self.uvs) > 2 * 4 * MAX_VERTICES:
            raise FileFormatError(self.path, number, f"expected at most {4 * MAX_VERTICES} texture coordinates")

    def read_face(self, words: list[bytes], number: int) -> None:
        if len(words) < 3:
            raise FileFormatError(self.path, number, "expected `f` with at least three corners")
        polygon = [self._corner(word, number) for word in words]
        first, count = len(self.corners) // 6, len(polygon) - 2
        if first + count > MAX_TRIANGLES:
            raise FileFormatError(self.path, number, f"expected at most {MAX_TRIANGLES} triangles")
        for i in range(1, count + 1):
            self.corners.extend((*polygon[0], *polygon[i], *polygon[i + 1]))
        for name in self.current:
            self.groups.setdefault(name, array("q")).extend(range(first, first + count))

    def _corner(self, word: bytes, number: int) -> tuple[int, int]:
        parts = word.split(b"/")
        try:
            position = _absolute(int(parts[0]), len(self.positions) // 3)
            uv = _absolute(int(parts[1]), len(self.uvs) // 2) if len(parts) > 1 and parts[1] else -1
        except ValueError as error:
            message = "expected corners `v`, `v/vt`, `v//vn` or `v/vt/vn` that name lines above"
            raise FileFormatError(self.path, number, message) from error
        return position, uv

    def read_group(self, words: list[bytes], number: int) -> None:
        self.current = list(dict.fromkeys(word.decode("utf-8", "replace") for word in words[:8])) or [DEFAULT_GROUP]

    def read_library(self, words: list[bytes], number: int) -> None:
        if self.library is None:
            self.library = b" ".join(words).decode("utf-8", "replace")

    def result(self) -> RawMesh:
        if not self.positions or not self.corners:
            raise FileFormatError(self.path, None, "expected an OBJ mesh with vertices (`v`) and faces (`f`)")
        return RawMesh(
            positions=np.array(self.positions).reshape(-1, 3),
            uvs=np.array(self.uvs).reshape(-1, 2),
            corners=np.array(self.corners, dtype=np.int64).reshape(-1, 3, 2),
            groups={name: np.array(triangles, dtype=np.int64) for name, triangles in self.groups.items()},
            texture=_find_texture(self.path, self.library) if self.library else None,
        )


_KEYWORDS: dict[bytes, Callable[[_ObjText, list[bytes], int], None]] = {
    b"v": _ObjText.read_position,
    b"vt": _ObjText.read_uv,
    b"f": _ObjText.read_face,
    b"g": _ObjText.read_group,
    b"mtllib": _ObjText.read_library,
}


def _absolute(index: int, count: int) -> int:
    """Return the index from 0 for an OBJ index (from 1, or from -1 backwards). Raises ValueError if out of range."""
    absolute = index - 1 if index > 0 else count + index
    if not 0 <= absolute < count or index == 0:
        raise ValueError(f"index {index} of {count}")
    return absolute


def _find_texture(path: Path, library: str) -> Path | None:
    """Return the first existing image file that the material library names, or None."""
    try:
        for _, line in read_lines(path.parent / library):
            words = line.split(None, 1)
            if len(words) == 2 and words[0] == b"map_Kd":
                texture = path.parent / words[1].strip().decode("utf-8", "replace").replace("\\", "/")
                if texture.is_file():
                    return texture
    except (FileFormatError, OSError, ValueError):
        return None
    return None
