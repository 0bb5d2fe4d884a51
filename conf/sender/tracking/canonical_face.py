"""The canonical face: the mean face that head pose is measured against, read from the tracker's own metadata.

Strategy: the metadata is a protocol buffer of a dozen field numbers. A reader of its wire format is thirty lines; the
protobuf package would be a dependency of several megabytes for one file of 19 kB.
Source: MediaPipe, modules/face_geometry/protos (mesh_3d.proto, geometry_pipeline_metadata.proto).
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import ModelError

FILE_NAME = "geometry_pipeline_metadata_landmarks.binarypb"
VERTEX_COUNT = 468
TRIANGLE_COUNT = 898
WEIGHT_COUNT = 33

_MESH, _WEIGHTED_LANDMARK = 1, 2  # fields of GeometryPipelineMetadata
_VERTEX_BUFFER, _INDEX_BUFFER = 3, 4  # fields of Mesh3d: x y z u v for each vertex; three indices for each triangle
_LANDMARK_ID, _WEIGHT = 1, 2  # fields of WeightedLandmarkRef
_VARINT, _FIXED64, _BYTES, _FIXED32 = 0, 1, 2, 5  # wire types

_Field = tuple[int, int | float | bytes]


@dataclass(frozen=True)
class CanonicalFace:
    """A mean face in centimetres: x to the subject's left, y up, z to the viewer; 6.3 cm between the eyes.

    vertices : (468, 3) float64 cm, in the order of the first 468 landmarks
    triangles : (898, 3) int32
    uvs : (468, 2) float64
    rigid : (33,) int, the landmarks that move least with the expression
    weights : (33,) float64, how much each counts when the head pose is found
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    uvs: NDArray[np.float64]
    rigid: NDArray[np.intp]
    weights: NDArray[np.float64]


def read_canonical_face(folder: Path, /) -> CanonicalFace:
    """Read the canonical face from a folder of the tracker's files. Raises ModelError."""
    path = folder / FILE_NAME
    try:
        return parse_canonical_face(path.read_bytes())
    except (OSError, ValueError) as error:
        raise ModelError(f"{path} cannot be read ({error}): run `conf models fetch` to get it again.") from error


def parse_canonical_face(data: bytes, /) -> CanonicalFace:
    """Parse the geometry metadata. Raises ValueError if the bytes are anything else."""
    fields = list(_read_fields(data))
    mesh = b"".join(value for number, value in fields if number == _MESH and isinstance(value, bytes))
    mesh_fields = list(_read_fields(mesh))
    floats = [value for number, value in mesh_fields if number == _VERTEX_BUFFER]
    indices = [value for number, value in mesh_fields if number == _INDEX_BUFFER]
    pairs = [
        dict(_read_fields(value))
        for number, value in fields
        if number == _WEIGHTED_LANDMARK and isinstance(value, bytes)
    ]
    counts = (len(floats), len(indices), len(pairs))
    if counts != (VERTEX_COUNT * 5, TRIANGLE_COUNT * 3, WEIGHT_COUNT):
        raise ValueError(f"not the face geometry: {counts} numbers, indices and weights")
    vertices = np.array(floats, dtype=np.float64).reshape(VERTEX_COUNT, 5)
    return CanonicalFace(
        vertices=vertices[:, :3],
        triangles=np.array(indices, dtype=np.int32).reshape(TRIANGLE_COUNT, 3),
        uvs=vertices[:, 3:],
        rigid=np.array([pair.get(_LANDMARK_ID, 0) for pair in pairs], dtype=np.intp),
        weights=np.array([pair.get(_WEIGHT, 0.0) for pair in pairs], dtype=np.float64),
    )


def _read_fields(data: bytes) -> Iterator[_Field]:
    """Yield the (field number, value) pairs of one protocol buffer message."""
    at = 0
    while at < len(data):
        key, at = _read_varint(data, at)
        value, at = _read_value(data, at, key & 7)
        yield key >> 3, value


def _read_value(data: bytes, at: int, wire_type: int) -> tuple[int | float | bytes, int]:
    if wire_type == _VARINT:
        return _read_varint(data, at)
    if wire_type == _BYTES:
        size, at = _read_varint(data, at)
        return _slice(data, at, size), at + size
    if wire_type == _FIXED32:
        value: float = struct.unpack("<f", _slice(data, at, 4))[0]
        return value, at + 4
    if wire_type == _FIXED64:
        return _slice(data, at, 8), at + 8
    raise ValueError(f"unknown wire type {wire_type} at byte {at}")


def _slice(data: bytes, at: int, size: int) -> bytes:
    if at + size > len(data):
        raise ValueError(f"cut off at byte {len(data)}")
    return data[at : at + size]


def _read_varint(data: bytes, at: int) -> tuple[int, int]:
    value = 0
    for shift in range(0, 70, 7):
        byte = _slice(data, at, 1)[0]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, at
    raise ValueError(f"a number longer than ten bytes at byte {at}")
