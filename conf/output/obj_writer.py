"""Write a moved face as OBJ: the vertices in the order of the mesh, texture coordinates, groups and picture kept."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.errors import ConfError
from conf.face.mesh.mesh import Mesh
from conf.render.materials import material_of

COMMON = (".png", ".jpg", ".jpeg", ".bmp", ".tga")  # pictures that every program with OBJ files reads
OPAQUE_MATERIAL, BLENDED_MATERIAL = "face", "hair"
MATERIALS = (
    f"newmtl {OPAQUE_MATERIAL}\nmap_Kd {{picture}}\n\n"
    f"newmtl {BLENDED_MATERIAL}\nmap_Kd {{picture}}\nmap_d {{picture}}\n"
)


def write_obj(path: Path, mesh: Mesh, vertices: NDArray[np.floating], /) -> None:
    """Write the mesh with its (V, 3) vertices somewhere else; its picture goes beside it, an MTL file names it.

    Raises ConfError if a file cannot be written.
    """
    try:
        picture = _write_picture(path, mesh.texture) if _textured(mesh) and mesh.texture else None
        if picture is not None:
            path.with_suffix(".mtl").write_text(MATERIALS.format(picture=picture.name), encoding="utf-8")
        with path.open("w", encoding="utf-8") as file:
            if picture is not None:
                file.write(f"mtllib {path.with_suffix('.mtl').name}\n")
            file.writelines(f"{line}\n" for line in _lines(mesh, vertices, painted=picture is not None))
    except OSError as error:
        raise ConfError(f"{path} cannot be written ({error.strerror}); choose another file or folder") from error


def _write_picture(path: Path, texture: Path) -> Path:
    """Write the picture of a mesh beside an OBJ file, as PNG if few programs read it as it is. Returns its path."""
    common = texture.suffix.lower() in COMMON
    copy = path.with_name(f"{path.stem}-texture{texture.suffix if common else '.png'}")
    if not common:
        pixels = cv2.imread(str(texture), cv2.IMREAD_UNCHANGED)
        if pixels is None:
            raise ConfError(f"{texture}: expected a picture; take it out of the mesh's MTL file")
        copy.write_bytes(cv2.imencode(".png", pixels)[1].tobytes())
    elif copy.resolve() != texture.resolve():
        shutil.copyfile(texture, copy)
    return copy


def _textured(mesh: Mesh) -> bool:
    return len(mesh.uvs) == len(mesh.render_vertices) and bool(np.any(mesh.uvs))


def _lines(mesh: Mesh, vertices: NDArray[np.floating], *, painted: bool) -> Iterator[str]:
    yield f"# {len(vertices)} vertices, {len(mesh.triangles)} triangles"
    yield from (f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in vertices.tolist())
    textured = _textured(mesh)
    if textured:
        yield from (f"vt {u:.6f} {v:.6f}" for u, v in mesh.uvs.tolist())
    rest = np.ones(len(mesh.triangles), np.bool_)
    for members in mesh.groups.values():
        rest[members] = False
    for name, triangles in (*mesh.groups.items(), ("rest", np.flatnonzero(rest))):
        if len(triangles):
            yield f"g {name}"
            if painted:
                yield f"usemtl {BLENDED_MATERIAL if material_of(name).blended else OPAQUE_MATERIAL}"
            yield from _faces(mesh, triangles, textured)


def _faces(mesh: Mesh, triangles: NDArray[np.integer], textured: bool) -> Iterator[str]:
    corners = mesh.triangles[triangles] + 1
    if not textured:
        yield from (f"f {a} {b} {c}" for a, b, c in corners.tolist())
        return
    uvs = mesh.render_triangles[triangles] + 1
    for positions, places in zip(corners.tolist(), uvs.tolist(), strict=True):
        yield "f " + " ".join(f"{p}/{t}" for p, t in zip(positions, places, strict=True))
