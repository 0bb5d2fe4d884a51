"""Write a moved face as OBJ: the vertices in the order of the mesh, texture coordinates and groups kept."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import ConfError
from conf.face.mesh import Mesh


def write_obj(path: Path, mesh: Mesh, vertices: NDArray[np.floating], /) -> None:
    """Write the mesh with its (V, 3) vertices somewhere else. Raises ConfError if the file cannot be written."""
    try:
        with path.open("w", encoding="utf-8") as file:
            file.writelines(f"{line}\n" for line in _lines(mesh, vertices))
    except OSError as error:
        raise ConfError(f"{path} cannot be written ({error.strerror}); choose another file or folder") from error


def _lines(mesh: Mesh, vertices: NDArray[np.floating]) -> Iterator[str]:
    yield f"# {len(vertices)} vertices, {len(mesh.triangles)} triangles"
    yield from (f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in vertices.tolist())
    textured = len(mesh.uvs) == len(mesh.render_vertices) and bool(np.any(mesh.uvs))
    if textured:
        yield from (f"vt {u:.6f} {v:.6f}" for u, v in mesh.uvs.tolist())
    left = np.ones(len(mesh.triangles), np.bool_)
    for name, triangles in mesh.groups.items():
        left[triangles] = False
        yield f"g {name}"
        yield from _faces(mesh, triangles, textured)
    if left.any():
        yield "g rest"
        yield from _faces(mesh, np.flatnonzero(left), textured)


def _faces(mesh: Mesh, triangles: NDArray[np.integer], textured: bool) -> Iterator[str]:
    corners = mesh.triangles[triangles] + 1
    if not textured:
        yield from (f"f {a} {b} {c}" for a, b, c in corners.tolist())
        return
    uvs = mesh.render_triangles[triangles] + 1
    for positions, places in zip(corners.tolist(), uvs.tolist(), strict=True):
        yield "f " + " ".join(f"{p}/{t}" for p, t in zip(positions, places, strict=True))
