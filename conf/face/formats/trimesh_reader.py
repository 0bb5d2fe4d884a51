"""Read PLY, GLB and STL meshes with trimesh."""

import logging
import struct
import warnings
from pathlib import Path

import numpy as np
import trimesh

from conf.errors import FileFormatError
from conf.face.formats.obj import DEFAULT_GROUP, MAX_TRIANGLES, MAX_VERTICES, RawMesh
from conf.face.formats.text import check_file

# What trimesh's readers raise for damaged files.
_READ_ERRORS = (
    *(ArithmeticError, AssertionError, AttributeError, BufferError, EOFError, ImportError, LookupError, MemoryError),
    *(NameError, OSError, RuntimeError, TypeError, ValueError, struct.error),
)


def read_with_trimesh(path: Path, /) -> RawMesh:
    """Read a PLY, GLB or STL mesh; parts become groups, vertices keep the file's order.

    Raises FileFormatError if trimesh cannot read it as a mesh.
    """
    check_file(path)
    kind = path.suffix.lower()[1:]
    try:
        with path.open("rb") as file, warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            scene = trimesh.load_scene(file, file_type=kind, process=False, maintain_order=True)
            parts = scene.dump()
            return _join(path, [part for part in parts if isinstance(part, trimesh.Trimesh) and len(part.faces)])
    except FileFormatError:
        raise
    except _READ_ERRORS as error:
        raise FileFormatError(path, None, f"expected a {kind.upper()} mesh, found something else") from error


def _join(path: Path, parts: list[trimesh.Trimesh]) -> RawMesh:
    if not parts:
        raise FileFormatError(path, None, "expected a mesh with triangles")
    positions = np.concatenate([np.asarray(part.vertices, dtype=np.float64) for part in parts])
    triangles = [np.asarray(part.faces, dtype=np.int64) for part in parts]
    if len(positions) > MAX_VERTICES or sum(map(len, triangles)) > MAX_TRIANGLES:
        raise FileFormatError(path, None, f"expected at most {MAX_VERTICES} vertices and {MAX_TRIANGLES} triangles")
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    ends = np.cumsum([0, *(len(t) for t in triangles)])
    corners = np.concatenate([t + start for t, start in zip(triangles, starts, strict=False)])
    uvs = [_uvs(part) for part in parts]
    textured = all(uv is not None for uv in uvs)
    return RawMesh(
        positions=positions,
        uvs=np.concatenate([uv for uv in uvs if uv is not None]) if textured else np.empty((0, 2)),
        corners=np.stack([corners, corners if textured else np.full_like(corners, -1)], axis=-1),
        groups={_group_name(part, i): np.arange(ends[i], ends[i + 1]) for i, part in enumerate(parts)},
        texture=None,  # a texture embedded in a GLB is not used
    )


def _uvs(part: trimesh.Trimesh) -> np.ndarray | None:
    uv = getattr(part.visual, "uv", None)
    usable = uv is not None and np.shape(uv) == (len(part.vertices), 2) and np.isfinite(uv).all()
    return np.asarray(uv, dtype=np.float64) if usable else None


def _group_name(part: trimesh.Trimesh, index: int) -> str:
    return f"{part.metadata.get('name', DEFAULT_GROUP)}{f'_{index}' if index else ''}"


logging.getLogger("trimesh").addHandler(logging.NullHandler())
