"""Write a deformed face as OBJ with MTL and texture; the order of vertices, texture coordinates and groups is kept."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.atomic_write import report_write_errors
from conf.errors import ConfError
from conf.face.mesh.mesh import Mesh
from conf.render.materials import group_triangles, material_of

PORTABLE_FORMATS = (".png", ".jpg", ".jpeg", ".bmp", ".tga")  # textures that every program with OBJ import reads
OPAQUE_MATERIAL, BLENDED_MATERIAL = "face", "hair"
MATERIALS = (
    f"newmtl {OPAQUE_MATERIAL}\nmap_Kd {{texture}}\n\n"
    f"newmtl {BLENDED_MATERIAL}\nmap_Kd {{texture}}\nmap_d {{texture}}\n"
)


def write_obj(path: Path, mesh: Mesh, vertices: NDArray[np.floating], /) -> None:
    """Write the mesh with (V, 3) other vertices, and beside it its texture and an MTL file that names the texture.

    Raises ConfError if a file cannot be written.
    """
    with report_write_errors(path):
        texture = _write_texture(path, mesh.texture) if _has_uvs(mesh) and mesh.texture else None
        if texture is not None:
            path.with_suffix(".mtl").write_text(MATERIALS.format(texture=texture.name), encoding="utf-8")
        with path.open("w", encoding="utf-8") as file:
            if texture is not None:
                file.write(f"mtllib {path.with_suffix('.mtl').name}\n")
            file.writelines(f"{line}\n" for line in _lines(mesh, vertices, has_texture=texture is not None))


def _write_texture(path: Path, texture: Path) -> Path:
    """Copy a texture beside an OBJ file, as PNG unless it is in a portable format. Returns the path of the copy."""
    is_portable = texture.suffix.lower() in PORTABLE_FORMATS
    copy = path.with_name(f"{path.stem}-texture{texture.suffix if is_portable else '.png'}")
    if not is_portable:
        pixels = cv2.imread(str(texture), cv2.IMREAD_UNCHANGED)
        if pixels is None:
            raise ConfError(f"{texture}: expected an image file; remove it from the mesh's MTL file")
        copy.write_bytes(cv2.imencode(".png", pixels)[1].tobytes())
    elif copy.resolve() != texture.resolve():
        shutil.copyfile(texture, copy)
    return copy


def _has_uvs(mesh: Mesh) -> bool:
    return len(mesh.uvs) == len(mesh.render_vertices) and bool(np.any(mesh.uvs))


def _lines(mesh: Mesh, vertices: NDArray[np.floating], *, has_texture: bool) -> Iterator[str]:
    yield f"# {len(vertices)} vertices, {len(mesh.triangles)} triangles"
    yield from (f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in vertices.tolist())
    has_uvs = _has_uvs(mesh)
    if has_uvs:
        yield from (f"vt {u:.6f} {v:.6f}" for u, v in mesh.uvs.tolist())
    for name, triangles in group_triangles(mesh):
        yield f"g {name}"
        if has_texture:
            yield f"usemtl {BLENDED_MATERIAL if material_of(name).blended else OPAQUE_MATERIAL}"
        corners = mesh.triangles[triangles] + 1
        if has_uvs:
            pairs = np.stack([corners, mesh.render_triangles[triangles] + 1], axis=2).tolist()
            yield from ("f " + " ".join(f"{v}/{t}" for v, t in face) for face in pairs)
        else:
            yield from (f"f {a} {b} {c}" for a, b, c in corners.tolist())
