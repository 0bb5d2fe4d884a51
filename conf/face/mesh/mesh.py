"""Triangle meshes as plain arrays, read from OBJ, PLY, STL, GLB, VRM and glTF files."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError
from conf.face.formats.mtl import MeshMaterial
from conf.face.formats.obj import RawMesh, read_obj


def _read_with_trimesh(path: Path) -> RawMesh:
    # Importing trimesh takes a fifth of the time that the default head, an OBJ file, takes to load with it.
    from conf.face.formats.trimesh_reader import read_with_trimesh

    return read_with_trimesh(path)


_READERS: dict[str, Callable[[Path], RawMesh]] = {
    ".obj": read_obj,
    ".ply": _read_with_trimesh,
    ".glb": _read_with_trimesh,
    ".vrm": _read_with_trimesh,  # a GLB file
    ".gltf": _read_with_trimesh,
    ".stl": _read_with_trimesh,
}
MESH_SUFFIXES = tuple(_READERS)
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
    texture : image file for the triangles without a material, or None
    materials, triangle_materials : the materials, and (F,) the index of each triangle's, -1 for none; None: all -1
    vertex_colours : (V, 3) float32, sRGB, 0 to 1, or None; they multiply the colour of the materials
    notes : what of the file was skipped or not found, for the user
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    uvs: NDArray[np.float64]
    render_vertices: NDArray[np.int32]
    render_triangles: NDArray[np.int32]
    groups: dict[str, NDArray[np.int64]]
    texture: Path | None = None
    materials: tuple[MeshMaterial, ...] = ()
    triangle_materials: NDArray[np.int32] | None = None
    vertex_colours: NDArray[np.float32] | None = None
    notes: tuple[str, ...] = ()

    def materials_of_triangles(self) -> NDArray[np.int32]:
        """Return (F,) the index of each triangle's material, -1 for none."""
        known = self.triangle_materials
        return np.full(len(self.triangles), -1, np.int32) if known is None else known

    def extended_colours(
        self, triangles: int, vertices: int
    ) -> tuple[NDArray[np.int32] | None, NDArray[np.float32] | None]:
        """Return `triangle_materials` and `vertex_colours` with more triangles without material, and white vertices."""
        materials, colours = self.triangle_materials, self.vertex_colours
        if materials is not None:
            materials = np.concatenate([materials, np.full(triangles, -1, np.int32)])
        if colours is not None:
            colours = np.concatenate([colours, np.ones((vertices, 3), np.float32)])
        return materials, colours

    def group_vertices(self, *names: str) -> NDArray[np.int64]:
        """Return the sorted indices of the vertices of the named groups; unknown groups add none."""
        used = [self.triangles[self.groups[name]].ravel() for name in names if name in self.groups]
        return np.unique(np.concatenate(used)).astype(np.int64) if used else np.empty(0, dtype=np.int64)


def load_mesh(path: Path | str, /) -> Mesh:
    """Read an OBJ, PLY, STL, GLB, VRM or glTF file; the winding of neighbouring triangles is made the same.

    Raises FileFormatError if the file is not a mesh with finite coordinates, whatever its bytes.
    """
    path = Path(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise FileFormatError(path, None, f"expected a mesh file ({', '.join(MESH_SUFFIXES)})")
    raw = reader(path)
    if not (np.isfinite(raw.positions).all() and np.abs(raw.positions).max() <= _MAX_COORDINATE):
        raise FileFormatError(path, None, f"expected finite coordinates of at most {_MAX_COORDINATE:g}")
    if raw.corners[..., 0].min() < 0 or raw.corners[..., 0].max() >= len(raw.positions):
        raise FileFormatError(path, None, "expected triangles between the file's vertices")
    a, b, c = (raw.positions[raw.corners[:, corner, 0]] for corner in range(3))
    if not np.cross(b - a, c - a).any():
        raise FileFormatError(path, None, "expected a mesh, found only triangles without area: export it again")
    return build_mesh(_with_consistent_winding(raw))


def _with_consistent_winding(raw: RawMesh) -> RawMesh:
    from conf.face.mesh.orientation import consistent_flips  # with SciPy, which a face from the cache does not need

    flips = consistent_flips(raw.positions, raw.corners[..., 0])
    count = np.count_nonzero(flips)
    if count == 0:
        return raw
    corners = np.where(flips[:, None, None], raw.corners[:, ::-1], raw.corners)
    return replace(raw, corners=corners, notes=(*raw.notes, f"turned {count} triangles that faced the wrong way"))


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
        materials=raw.materials,
        triangle_materials=raw.triangle_materials,
        vertex_colours=raw.vertex_colours,
        notes=raw.notes,
    )
