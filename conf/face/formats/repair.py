"""Rewrite binary PLY and STL files that trimesh refuses, though all of their triangles are there.

PLY: faces of three and of more corners in one file, as Blender writes them. STL: a wrong count, or bytes that follow.
Source: Turk, "The PLY Polygon File Format", 1994; 3D Systems, "StereoLithography Interface Specification", 1988.
"""

import codecs
import struct
from dataclasses import dataclass

import numpy as np

_TYPES = {
    **dict.fromkeys(("char", "int8"), "b"), **dict.fromkeys(("uchar", "uint8"), "B"),
    **dict.fromkeys(("short", "int16"), "h"), **dict.fromkeys(("ushort", "uint16"), "H"),
    **dict.fromkeys(("int", "int32"), "i"), **dict.fromkeys(("uint", "uint32"), "I"),
    **dict.fromkeys(("float", "float32"), "f"), **dict.fromkeys(("double", "float64"), "d"),
}  # fmt: skip
_CORNERS = ("vertex_indices", "vertex_index")
_MAX_HEADER = 1 << 16  # bytes
_STL_HEADER = struct.Struct("<80sI")
_STL_TRIANGLE_BYTES = 50


@dataclass(frozen=True)
class _Property:
    """A property of a PLY element; count_type : of the length of a list, None for one number."""

    name: str
    type: str
    count_type: str | None


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property]
    line: int  # of the header


def repair(kind: str, data: bytes, notes: list[str], /) -> bytes:
    """Return the bytes of a "ply" or "stl" file in the form that all readers know; unchanged if it has that form.

    notes : what was missing is appended
    """
    if kind == "stl":
        return _repair_stl(data, notes)
    try:
        return _repair_ply(data) if kind == "ply" else data
    except (ValueError, KeyError, IndexError, OverflowError, struct.error):
        return data  # the reader says what is wrong


def _repair_stl(data: bytes, notes: list[str]) -> bytes:
    data = data.removeprefix(codecs.BOM_UTF8)
    if len(data) < _STL_HEADER.size or (data[:5].lower() == b"solid" and b"facet" in data[:1000].lower()):
        return data
    name, stated = _STL_HEADER.unpack_from(data)
    count = min(stated, (len(data) - _STL_HEADER.size) // _STL_TRIANGLE_BYTES)
    if count == 0:
        return data
    if count < stated:
        notes.append(f"the file ends after {count} of {stated} triangles")
    end = _STL_HEADER.size + count * _STL_TRIANGLE_BYTES
    return _STL_HEADER.pack(name, count) + data[_STL_HEADER.size : end]


def _repair_ply(data: bytes) -> bytes:
    """Return a PLY file whose faces are triangles, with nothing after them."""
    size = data.index(b"end_header", 0, _MAX_HEADER)
    size = data.index(b"\n", size) + 1
    lines = data[:size].decode("ascii", "replace").splitlines()
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}[lines[1].split()[1]]
    elements = _elements(lines)
    number = [element.name for element in elements].index("face")
    start = size + sum(element.count * struct.calcsize(order + _row(element)) for element in elements[:number])
    face = elements[number]
    if _is_uniform(data, start, face, order):
        return data
    polygons = _polygons(data, start, face, order)
    if not polygons:
        return data
    triangles = [(p[0], p[i], p[i + 1]) for p in polygons for i in range(1, len(p) - 1)]
    rows = np.zeros(len(triangles), np.dtype([("n", "u1"), ("corners", order + "i4", 3)]))
    rows["n"], rows["corners"] = 3, triangles
    header = [*lines[: face.line], f"element face {len(triangles)}", f"property list uchar int {_CORNERS[0]}"]
    return "\n".join([*header, "end_header\n"]).encode() + data[size:start] + rows.tobytes()


def _elements(lines: list[str]) -> list[_Element]:
    elements: list[_Element] = []
    for number, line in enumerate(lines):
        words = line.split()
        if words[:1] == ["element"]:
            elements.append(_Element(words[1], int(words[2]), [], number))
        elif words[:2] == ["property", "list"]:
            elements[-1].properties.append(_Property(words[4], _TYPES[words[3]], _TYPES[words[2]]))
        elif words[:1] == ["property"]:
            elements[-1].properties.append(_Property(words[2], _TYPES[words[1]], None))
    return elements


def _row(element: _Element) -> str:
    """Return the struct format of a row. Raises ValueError if it has lists, so that rows differ in length."""
    if any(one.count_type for one in element.properties):
        raise ValueError("rows of different lengths")
    return "".join(one.type for one in element.properties)


def _is_uniform(data: bytes, start: int, face: _Element, order: str) -> bool:
    """Return whether all faces have as many corners as the first, which is nearly always so."""
    (one,) = (prop for prop in face.properties if prop.name in _CORNERS)
    if one is not face.properties[0] or one.count_type is None or any(p.count_type for p in face.properties[1:]):
        return False
    (corners,) = struct.unpack_from(order + one.count_type, data, start)
    row = [("n", order + one.count_type), ("corners", order + one.type, max(corners, 0))]
    row += [(f"more {i}", order + more.type) for i, more in enumerate(face.properties[1:])]
    dtype = np.dtype(row)
    if start + face.count * dtype.itemsize > len(data):
        return False
    return bool((np.frombuffer(data, dtype, face.count, start)["n"] == corners).all())


def _polygons(data: bytes, start: int, face: _Element, order: str) -> list[tuple[int, ...]]:
    """Return the vertices of each face if the faces differ in their number, else nothing."""
    polygons, at = [], start
    for _ in range(face.count):
        for one in face.properties:
            count = 1
            if one.count_type is not None:
                (count,) = struct.unpack_from(order + one.count_type, data, at)
                at += struct.calcsize(one.count_type)
            if count < 0 or at > len(data):
                raise ValueError("rows outside the file")
            if one.name in _CORNERS:
                polygons.append(struct.unpack_from(f"{order}{count}{one.type}", data, at))
            at += count * struct.calcsize(one.type)
    lengths = {len(polygon) for polygon in polygons}
    return polygons if len(lengths) > 1 else []
