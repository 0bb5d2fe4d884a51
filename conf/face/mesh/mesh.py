"""Triangle meshes as plain arrays, read from OBJ, PLY, GLB and STL files."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError
from conf.face.formats.obj import RawMesh, read_obj
from conf.face.formats.trimesh_reader import read_with_trimesh

_READERS: dict[str, Callable[[Path], RawMesh]] = {
    ".obj": read_obj,
    ".ply": read_with_trimesh,
    ".glb": read_with_trimesh,
    ".stl": read_with_trimesh,
}
_MAX_COORDINATE = 1e9


@dataclass(frozen=True)
class Mesh:
    """A mesh with two sets of vertices: one for deformation, and one for rendering, split along texture seams.

    vertices : (V, 3) float64, in the order of the file
    triangles : (F, 3) int32, indices into vertices
    uvs : (R, 2) float64, texture coordinates of each render vertex, v upwards
    render_vertices : (R,) int32, render vertex -> vertex
    render_triangles : (F, 3) int32, indices into render vertices
    groups : name -> indices of its triangles
    texture : image file for the uvs, or None
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    uvs: NDArray[np.float64]
    render_vertices: NDArray[np.int32]
    render_triangles: NDArray[np.int32]
    groups: dict[str, NDArray[np.int64]]
    texture: Path | None = None

    def group_vertices(self, *names: str) -> NDArray[np.int64]:
        """Return the sorted indices of the vertices of the named groups; unknown groups add none."""
        used = [self.triangles[self.groups[name]].ravel() for name in names if name in self.groups]
        return np.unique(np.concatenate(used)).astype(np.int64) if used else np.empty(0, dtype=np.int64)


def load_mesh(path: Path | str, /) -> Mesh:
    """Read an OBJ, PLY, GLB or STL file.

    Raises FileFormatError if the file is not a mesh with finite coordinates, whatever its bytes.
    """
    path = Path(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise FileFormatError(path, None, f"expected a mesh file ({', '.join(_READERS)})")
    raw = reader(path)
    if not (np.isfinite(raw.positions).all() and np.abs(raw.positions).max() <= _MAX_COORDINATE):
        raise FileFormatError(path, None, f"expected finite coordinates of at most {_MAX_COORDINATE:g}")
    if raw.corners[..., 0].min() < 0 or raw.corners[..., 0].max() >= len(raw.positions):
        raise FileFormatError(path, None, "expected triangles between the file's vertices")
    return build_mesh(raw)


def build_mesh(raw: RawMesh, /) -> Mesh:
    """Return the mesh with one render vertex for each pair of position and texture coordinates that occurs."""
    keys = raw.corners[..., 0] * (len(raw.uvs) + 1) + raw.corners[..., 1] + 1
    pairs, inverse = np.unique(keys, return_inverse=True)
    positions, uv_numbers = np.divmod(pairs, len(raw.uvs) + 1)
    uvs = np.concatenate([np.zeros((1, 2)), raw.uvs])  # row 0: no texture coordinates
    return Mesh(
        vertices=raw.positions,
        triangles=raw.corners[..., 0].astype(np.int32),
        uvs=uvs[uv_numbers],
        render_vertices=positions.astype(np.int32),
        render_triangles=inverse.reshape(-1, 3).astype(np.int32),
        groups=raw.groups,
        texture=raw.texture,
    )
