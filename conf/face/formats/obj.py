"""Read OBJ files, as leniently as viewers do.

trimesh reads OBJ too, but splits the file into one mesh per material, reorders and merges vertices, and drops the names
of groups. Here the order of the `v` lines is the vertex order of every array (operator, blendshapes), and the groups
tell which part is an eye or a tooth. A line that cannot be used is skipped, counted and named in the notes.
"""

from array import array
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError
from conf.face.formats.mtl import MeshMaterial, read_material_libraries
from conf.face.formats.polygons import split_concave
from conf.face.formats.text import decode_name, read_lines

MAX_VERTICES = 1_000_000
MAX_TRIANGLES = 2_000_000
DEFAULT_GROUP = "default"
_MAX_NAMES = 10_000  # groups, and materials: more are put into the first
_MAX_SKIPPED = 100_000  # lines: a file with more is not OBJ
_MAX_NUMBER = 1e9  # of a coordinate
_NO_MATERIAL = ""

# Keywords of the format that are not used; normals are computed for every frame.
_IGNORED = frozenset(
    b"vn vp s l p mg lod usemap maplib shadow_obj trace_obj cstype deg bmat step curv curv2 surf parm trim"
    b" hole scrv sp end con bevel c_interp d_interp ctech stech call csh bsp bzp cdc cdp res".split()
)


@dataclass(frozen=True)
class RawMesh:
    """A mesh with separately indexed positions and texture coordinates, as in files.

    positions : (V, 3) float64, in the file's order
    uvs : (T, 2) float64
    corners : (F, 3, 2) int64, position index and texture coordinate index (-1: none) of each corner
    groups : name -> indices of its triangles
    texture : existing image file for triangles without a material, or None
    materials, triangle_materials : the materials, and (F,) the index of each triangle's, -1 for none; None: all -1
    vertex_colours : (V, 3) float32, sRGB, 0 to 1, or None
    notes : what was skipped or not found, each one sentence for the user
    """

    positions: NDArray[np.float64]
    uvs: NDArray[np.float64]
    corners: NDArray[np.int64]
    groups: dict[str, NDArray[np.int64]]
    texture: Path | None
    materials: tuple[MeshMaterial, ...] = ()
    triangle_materials: NDArray[np.int32] | None = None
    vertex_colours: NDArray[np.float32] | None = None
    notes: tuple[str, ...] = ()


def read_obj(path: Path, /) -> RawMesh:
    """Read positions, texture coordinates, colours, polygons (as triangle fans), groups and materials.

    Raises FileFormatError if the file holds nothing that can be drawn, or is too large.
    """
    text = _ObjText(path)
    lines = read_lines(path, on_long_line=lambda number: text.skip("lines of over 64 KB", number))
    for number, line in _joined(lines):
        words = line.split(b"#", 1)[0].split()
        if words:
            text.read(words, line, number)
    return text.result()


def _joined(lines: Iterable[tuple[int, bytes]]) -> Iterator[tuple[int, bytes]]:
    """Yield the lines; up to a hundred that end in a backslash are joined with the next."""
    parts: list[bytes] = []
    number = 0
    for number, line in lines:
        if line.endswith((b"\\", b"\\ ", b"\\\t")):
            parts.append(line.rstrip()[:-1])
            if len(parts) <= 100:
                continue
            line = b""
        yield number, b" ".join([*parts, line]) if parts else line
        parts.clear()
    if parts:
        yield number, b" ".join(parts)


@dataclass
class _ObjText:
    """Parser state of one OBJ file; flat arrays need a tenth of the memory of lists.

    group_runs, material_runs : first triangle and names of each run of triangles
    skipped : what was skipped -> how often, and the first line
    """

    path: Path
    positions: "array[float]" = field(default_factory=lambda: array("d"))  # three per vertex
    colours: "array[float]" = field(default_factory=lambda: array("f"))  # three per vertex, up to the last with colour
    uvs: "array[float]" = field(default_factory=lambda: array("d"))  # two per texture coordinate
    corners: "array[int]" = field(default_factory=lambda: array("q"))  # six per triangle, as in RawMesh
    polygons: "array[int]" = field(default_factory=lambda: array("q"))  # two per polygon, as in split_concave
    group_runs: list[tuple[int, list[str]]] = field(default_factory=list)
    material_runs: list[tuple[int, str]] = field(default_factory=list)
    object_name: str = DEFAULT_GROUP
    groups: list[str] = field(default_factory=lambda: [DEFAULT_GROUP])
    material: str = _NO_MATERIAL
    libraries: list[str] = field(default_factory=list)
    skipped: dict[str, list[int]] = field(default_factory=dict)

    def read(self, words: list[bytes], line: bytes, number: int) -> None:
        """Read one line; words : the line without its comment, split at blanks."""
        keyword = words[0]
        reader = _KEYWORDS.get(keyword)
        if reader is None and keyword.isupper():  # some programs write V and F
            keyword = keyword.lower()
            reader = _KEYWORDS.get(keyword)
        if reader is not None:
            reader(self, words[1:], number)
        elif keyword in _NAMES:
            parts = line.split(None, 1)
            _NAMES[keyword](self, decode_name(parts[1]).strip() if len(parts) > 1 else "")
        elif keyword not in _IGNORED:
            self.skip("lines with an unknown keyword", number)

    def skip(self, kind: str, number: int) -> None:
        """Count a line that is not used."""
        count = self.skipped.setdefault(kind, [0, number])
        count[0] += 1
        if count[0] > _MAX_SKIPPED:
            raise FileFormatError(self.path, number, f"expected an OBJ file, found over {_MAX_SKIPPED:,} {kind}")

    def read_position(self, words: list[bytes], number: int) -> None:
        try:
            x, y, z = map(float, words[:3])
        except ValueError:
            x, y, z = _floats_with_commas(words, 3)
        self.positions.extend((x, y, z))
        if not (x - x == 0.0 and y - y == 0.0 and z - z == 0.0):  # nan or infinite
            self.skip("vertices without three finite coordinates", number)
        if len(words) >= 6:  # also with a weight, or more numbers after the colour
            self.colours.extend(1.0 for _ in range(len(self.positions) - 3 - len(self.colours)))
            self.colours.extend(_floats_with_commas(words[3:6], 3))
        if len(self.positions) > 3 * MAX_VERTICES:
            raise FileFormatError(self.path, number, f"expected at most {MAX_VERTICES} vertices")

    def read_uv(self, words: list[bytes], number: int) -> None:
        try:
            u, v = map(float, words[:2]) if len(words) > 1 else (float(words[0]), 0.0)
        except (ValueError, IndexError):
            u, v = _floats_with_commas(words, 2)
        self.uvs.extend((u, v))
        if not (u - u == 0.0 and v - v == 0.0):
            self.skip("texture coordinates that are no numbers", number)
        if len(self.uvs) > 2 * 4 * MAX_VERTICES:
            raise FileFormatError(self.path, number, f"expected at most {4 * MAX_VERTICES} texture coordinates")

    def read_face(self, words: list[bytes], number: int) -> None:
        if len(words) < 3:
            self.skip("faces with fewer than three corners", number)
            return
        first, count = len(self.corners) // 6, len(words) - 2
        if first + count > MAX_TRIANGLES:
            raise FileFormatError(self.path, number, f"expected at most {MAX_TRIANGLES} triangles")
        try:
            polygon = [self._corner(word) for word in words]
            for i in range(1, count + 1):
                self.corners.extend((*polygon[0], *polygon[i], *polygon[i + 1]))
        except (ValueError, OverflowError):
            del self.corners[6 * first :]
            self.skip("faces that cannot be read", number)
            return
        if count > 1:
            self.polygons.extend((first, count))
        if not self.group_runs or self.group_runs[-1][1] is not self.groups:
            self.group_runs.append((first, self.groups))
        if not self.material_runs or self.material_runs[-1][1] != self.material:
            self.material_runs.append((first, self.material))

    def _corner(self, word: bytes) -> tuple[int, int]:
        """Return the indices from 0 of position and texture coordinates; -1 for none. Later lines may define them."""
        parts = word.split(b"/")
        position = int(parts[0])
        uv = int(parts[1]) if len(parts) > 1 and parts[1] else 0
        if position < 0:  # counts backwards
            position = max(len(self.positions) // 3 + position + 1, 0)
        if uv < 0:
            uv = max(len(self.uvs) // 2 + uv + 1, 0)
        return position - 1, uv - 1

    def read_groups(self, text: str) -> None:
        names = list(dict.fromkeys(text.split("#", 1)[0].split()[:8]))
        self.groups = [self.object_name] if names in ([], [DEFAULT_GROUP]) else names

    def read_object(self, text: str) -> None:
        self.object_name = text.split("#", 1)[0].strip() or DEFAULT_GROUP
        self.groups = [self.object_name]

    def read_material(self, text: str) -> None:
        self.material = text

    def read_library(self, text: str) -> None:
        if text not in self.libraries and len(self.libraries) < 100:
            self.libraries.append(text)

    def result(self) -> RawMesh:
        """Return the mesh of everything that was read and can be drawn."""
        positions = np.array(self.positions).reshape(-1, 3)
        uvs = np.array(self.uvs).reshape(-1, 2)
        corners = np.array(self.corners, dtype=np.int64).reshape(-1, 3, 2)
        if self.polygons:
            split_concave(positions, corners, np.array(self.polygons, dtype=np.int64).reshape(-1, 2))
        notes = list(self.notes())
        kept = drop_unusable(self.path, positions, corners[..., 0], notes)
        usable_uvs = np.append((np.abs(uvs) <= _MAX_NUMBER).all(axis=1), [True])
        past = corners[..., 1] >= len(uvs)
        if past.any():
            notes.append(f"{np.count_nonzero(past)} corners name texture coordinates that do not exist")
            corners[..., 1][past] = -1
        if not usable_uvs.all():
            corners[..., 1][~usable_uvs[corners[..., 1]]] = -1
            uvs[~usable_uvs[:-1]] = 0.0
        materials = read_material_libraries(self.path, self.libraries, notes) if self.libraries else {}
        names, triangle_materials = self._triangle_materials(len(corners))
        used, numbers = _resolve_materials(names, materials, triangle_materials[kept], notes)
        raw = RawMesh(positions, uvs, corners[kept], self._groups(kept), None, notes=tuple(notes))
        return with_materials(raw, used, numbers, self._vertex_colours(len(positions)))

    def notes(self) -> tuple[str, ...]:
        """Return what was skipped, as at most one sentence."""
        kinds = (f"{count} {kind} (first in line {line})" for kind, (count, line) in self.skipped.items())
        text = ", ".join(kinds)
        return (f"skipped {text}",) if text else ()

    def _groups(self, kept: NDArray[np.bool_]) -> dict[str, NDArray[np.int64]]:
        """Return the groups of the kept triangles, renumbered."""
        numbers = np.cumsum(kept) - 1
        ends = [first for first, _ in self.group_runs[1:]] + [len(kept)]
        members: dict[str, list[NDArray[np.int64]]] = {}
        for (first, names), end in zip(self.group_runs, ends, strict=True):
            run = numbers[first:end][kept[first:end]]
            for name in names if len(run) else ():
                known = name if name in members or len(members) < _MAX_NAMES else next(iter(members))
                members.setdefault(known, []).append(run)
        return {name: np.unique(np.concatenate(runs)) for name, runs in members.items()}

    def _triangle_materials(self, count: int) -> tuple[list[str], NDArray[np.int32]]:
        """Return the names of the materials that are used, and (F,) the number of each triangle's."""
        numbers: dict[str, int] = {}
        runs = [
            numbers.setdefault(name, len(numbers)) if name in numbers or len(numbers) < _MAX_NAMES else 0
            for _, name in self.material_runs
        ]
        ends = [first for first, _ in self.material_runs[1:]] + [count]
        lengths = np.diff([*(first for first, _ in self.material_runs), ends[-1]])
        return list(numbers), np.repeat(np.array(runs, dtype=np.int32), lengths)

    def _vertex_colours(self, count: int) -> NDArray[np.float32] | None:
        """Return the (V, 3) colours, 0 to 1, or None if the file has none that tell anything."""
        if not self.colours:
            return None
        colours = np.ones((count, 3), np.float32)
        colours[: len(self.colours) // 3] = np.array(self.colours, dtype=np.float32).reshape(-1, 3)
        colours[~np.isfinite(colours)] = 1.0
        return colours / 255.0 if colours.max() > 1.5 else colours


_KEYWORDS: dict[bytes, Callable[[_ObjText, list[bytes], int], None]] = {
    b"v": _ObjText.read_position,
    b"vt": _ObjText.read_uv,
    b"f": _ObjText.read_face,
    b"fo": _ObjText.read_face,  # of version 2 of the format
}
# What follows these keywords may hold blanks.
_NAMES: dict[bytes, Callable[[_ObjText, str], None]] = {
    b"g": _ObjText.read_groups,
    b"o": _ObjText.read_object,
    b"usemtl": _ObjText.read_material,
    b"mtllib": _ObjText.read_library,
}


def _floats_with_commas(words: list[bytes], count: int) -> tuple[float, ...]:
    """Return numbers that may have decimal commas; nan for what is no number or missing."""
    values = []
    for word in (*words, *(b"",) * count)[:count]:
        try:
            values.append(float(word.replace(b",", b".")))
        except ValueError:
            values.append(float("nan"))
    return tuple(values)


def _resolve_materials(
    names: list[str], library: dict[str, MeshMaterial], numbers: NDArray[np.int32], notes: list[str]
) -> tuple[tuple[MeshMaterial, ...], NDArray[np.int32]]:
    """Return the materials that the triangles use, and (F,) the index of each triangle's, -1 for none."""
    in_any_case = {name.casefold(): material for name, material in reversed(library.items())}
    found = [library.get(name, in_any_case.get(name.casefold())) for name in names]
    missing = [name for name, material in zip(names, found, strict=True) if material is None and name != _NO_MATERIAL]
    if library and missing:
        notes.append(f"the material {missing[0]} is not in the material library")
    if all(material is None for material in found):  # the only texture of a library is meant, whatever its name
        textured = [material for material in library.values() if material.image is not None]
        return (tuple(textured[:1]), np.full(len(numbers), 0 if textured else -1, np.int32))
    indices = np.cumsum([material is not None for material in found]) - 1
    mapping = np.where([material is not None for material in found], indices, -1).astype(np.int32)
    return tuple(material for material in found if material is not None), mapping[numbers]


def drop_unusable(
    path: Path, positions: NDArray[np.float64], triangles: NDArray[np.int64], notes: list[str]
) -> NDArray[np.bool_]:
    """Return (F,) which of the triangles (F, 3) are kept: those between existing vertices with finite coordinates.

    positions : (V, 3); those that cannot be used are set to the mean of the others
    Raises FileFormatError if none is left.
    """
    usable = np.asarray((np.abs(positions) <= _MAX_NUMBER).all(axis=1), dtype=np.bool_)  # False for nan
    kept = np.asarray(((triangles >= 0) & (triangles < len(positions))).all(axis=1), dtype=np.bool_)
    kept[kept] = usable[triangles[kept]].all(axis=1)
    if not kept.any():
        kind = path.suffix[1:].upper()
        expected = f"expected {'an' if kind == 'OBJ' else 'a'} {kind} mesh with vertices and faces between them"
        raise FileFormatError(path, None, "; ".join((expected, *notes)))
    if not usable.all():
        positions[~usable] = positions[usable].mean(axis=0)
    if not kept.all():
        notes.append(f"skipped {np.count_nonzero(~kept)} triangles whose vertices are missing")
    return kept


def with_materials(
    raw: RawMesh,
    materials: tuple[MeshMaterial, ...],
    triangle_materials: NDArray[np.int32],
    vertex_colours: NDArray[np.float32] | None,
) -> RawMesh:
    """Return the mesh with its materials, reduced to what changes how it is drawn.

    One image for all triangles becomes the mesh's texture. A single grey material without image is what programs write
    when no colour was chosen: it counts as none. Triangles without material take the vertex colours, if there are any.
    """
    materials = tuple(replace(m, colour=(1.0, 1.0, 1.0)) if isinstance(m.image, Path) else m for m in materials)
    if vertex_colours is not None and (np.ptp(vertex_colours, axis=0) < 1e-3).all() and _is_grey(vertex_colours[0]):
        vertex_colours = None
    used = [materials[i] for i in np.unique(triangle_materials) if i >= 0]
    covers_all = len(used) > 0 and int(triangle_materials.min()) >= 0
    if covers_all and all(_is_plain_texture(m) and m.image == used[0].image for m in used):
        image = used[0].image
        return replace(raw, texture=image if isinstance(image, Path) else None)
    is_bare = all(m.image is None and m.alpha == 1.0 for m in used)
    if is_bare and len({m.colour for m in used}) <= 1 and all(_is_grey(m.colour) for m in used):
        materials, triangle_materials = (), np.full_like(triangle_materials, -1)
    if vertex_colours is not None:
        triangle_materials = np.where(triangle_materials < 0, len(materials), triangle_materials).astype(np.int32)
        materials = (*materials, MeshMaterial())
    if not materials:
        return raw
    raw = replace(raw, materials=materials, triangle_materials=triangle_materials, vertex_colours=vertex_colours)
    return _with_transformed_uvs(raw, materials, triangle_materials)


def _is_grey(colour: "NDArray[np.float32] | tuple[float, float, float]") -> bool:
    return max(colour) - min(colour) < 1e-3


def _is_plain_texture(material: MeshMaterial) -> bool:
    """Return whether a material is its image file and nothing else."""
    return (
        isinstance(material.image, Path)
        and material.alpha == 1.0
        and material.alpha_image in (None, material.image)
        and (material.uv_scale, material.uv_offset) == ((1.0, 1.0), (0.0, 0.0))
    )


def _with_transformed_uvs(
    raw: RawMesh, materials: tuple[MeshMaterial, ...], triangle_materials: NDArray[np.int32]
) -> RawMesh:
    """Return the mesh with the scales and offsets of its materials applied to the texture coordinates."""
    uvs, corners = [raw.uvs], raw.corners.copy()
    for number, material in enumerate(materials):
        rows = triangle_materials == number
        if (material.uv_scale, material.uv_offset) == ((1.0, 1.0), (0.0, 0.0)) or not rows.any() or not len(raw.uvs):
            continue
        own = corners[rows, :, 1]
        corners[rows, :, 1] = np.where(own >= 0, own + sum(map(len, uvs)), -1)
        uvs.append(raw.uvs * material.uv_scale + material.uv_offset)
    return replace(raw, uvs=np.concatenate(uvs), corners=corners)
