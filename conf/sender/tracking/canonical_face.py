"""The canonical face: the mean face that head pose is measured against, read from the tracker's own metadata.

Strategy: the metadata is a protocol buffer with six field numbers. A reader of its wire format is thirty lines; the
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


@dataclass(frozen=True)
class CanonicalFace:
    """A mean face in centimetres: x to the subject's left, y up, z to the viewer; 6.3 cm between the eyes.

    vertices : (468, 3) float64 cm, in the order of the first 468 landmarks
    triangles : (898, 3) int32
    rigid : (33,) int, the landmarks that move little with the expression
    weights : (33,) float64, their weights in the estimation of the head pose
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
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
    messages = [(number, value) for number, value in fields if isinstance(value, bytes)]
    mesh = list(_read_fields(b"".join(value for number, value in messages if number == _MESH)))
    floats = [value for number, value in mesh if number == _VERTEX_BUFFER]
    indices = [value for number, value in mesh if number == _INDEX_BUFFER]
    weighted = [dict(_read_fields(value)) for number, value in messages if number == _WEIGHTED_LANDMARK]
    counts = (len(floats), len(indices), len(weighted))
    if counts != (VERTEX_COUNT * 5, TRIANGLE_COUNT * 3, WEIGHT_COUNT):
        raise ValueError(f"not the face geometry: {counts} numbers, indices and weights")
    return CanonicalFace(
        vertices=np.array(floats, dtype=np.float64).reshape(VERTEX_COUNT, 5)[:, :3],
        triangles=np.array(indices, dtype=np.int32).reshape(TRIANGLE_COUNT, 3),
        rigid=np.array([landmark.get(_LANDMARK_ID, 0) for landmark in weighted], dtype=np.intp),
        weights=np.array([landmark.get(_WEIGHT, 0.0) for landmark in weighted], dtype=np.float64),
    )


def _read_fields(data: bytes) -> Iterator[tuple[int, int | float | bytes]]:
    """Yield the (field number, value) pairs of one protocol buffer message."""
    position = 0
    while position < len(data):
        key, position = _read_varint(data, position)
        value: int | float | bytes
        match key & 7:
            case 0:  # varint
                value, position = _read_varint(data, position)
            case 2:  # bytes
                size, position = _read_varint(data, position)
                value, position = _slice(data, position, size), position + size
            case 5:  # float
                value, position = struct.unpack("<f", _slice(data, position, 4))[0], position + 4
            case wire_type:
                raise ValueError(f"unknown wire type {wire_type} at byte {position}")
        yield key >> 3, value


def _slice(data: bytes, start: int, size: int) -> bytes:
    if start + size > len(data):
        raise ValueError(f"cut off at byte {len(data)}")
    return data[start : start + size]


def _read_varint(data: bytes, position: int) -> tuple[int, int]:
    """Return a number and the position after it."""
    value = 0
    for shift in range(0, 70, 7):
        byte = _slice(data, position, 1)[0]
        position += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, position
    raise ValueError(f"a number longer than ten bytes at byte {position}")
