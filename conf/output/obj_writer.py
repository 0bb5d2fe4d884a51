"""Write a deformed face as OBJ with MTL and texture; the order of vertices, texture coordinates and groups is kept."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.atomic_write import atomic_write, report_write_errors
from conf.errors import ConfError, FileFormatError
from conf.face.mesh.mesh import Mesh
from conf.render.materials import group_triangles, material_of
from conf.render.textures import read_image, read_image_file

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
        is_textured = mesh.texture is not None and _has_uvs(mesh) and bool((mesh.materials_of_triangles() < 0).any())
        texture = _write_texture(path, mesh.texture) if mesh.texture and is_textured else None
        library = "" if texture is None else MATERIALS.format(texture=texture.name)
        library += "".join(_material_text(path, mesh, number) for number in _used_materials(mesh))
        if library:
            with atomic_write(path.with_suffix(".mtl")) as partial:
                partial.write_text(library, encoding="utf-8", errors="surrogateescape")  # names may be any bytes
        with atomic_write(path) as partial, partial.open("w", encoding="utf-8", errors="surrogateescape") as file:
            if library:
                file.write(f"mtllib {path.with_suffix('.mtl').name}\n")
            file.writelines(f"{line}\n" for line in _lines(mesh, vertices, has_texture=texture is not None))


def _write_texture(path: Path, texture: Path) -> Path:
    """Copy a texture beside an OBJ file, as PNG unless it is in a portable format. Returns the path of the copy."""
    is_portable = texture.suffix.lower() in PORTABLE_FORMATS
    copy = path.with_name(f"{path.stem}-texture{texture.suffix if is_portable else '.png'}")
    if not is_portable:
        try:
            pixels = read_image_file(texture)
        except FileFormatError as error:
            raise ConfError(f"{texture}: expected an image file; remove it from the mesh's MTL file") from error
        _write_png(copy, pixels)
    elif copy.resolve() != texture.resolve():
        with atomic_write(copy) as partial:
            shutil.copyfile(texture, partial)
    return copy


def _write_png(path: Path, pixels: NDArray[np.uint8]) -> None:
    with atomic_write(path) as partial:
        partial.write_bytes(cv2.imencode(".png", pixels)[1].tobytes())


def _used_materials(mesh: Mesh) -> list[int]:
    return [number for number in np.unique(mesh.materials_of_triangles()).tolist() if number >= 0]


def _material_text(path: Path, mesh: Mesh, number: int) -> str:
    """Return the MTL text of one of the mesh's materials, and write its image with its alpha as PNG."""
    material = mesh.materials[number]
    lines = [f"newmtl material_{number}", "Kd {:.4f} {:.4f} {:.4f}".format(*material.colour), f"d {material.alpha:.4f}"]
    if material.image is not None:
        image = path.with_name(f"{path.stem}-texture{number}.png")
        pixels = np.asarray(cv2.cvtColor(read_image(material)[::-1], cv2.COLOR_RGBA2BGRA), np.uint8)
        _write_png(image, pixels)
        lines += [f"map_Kd {image.name}", *([f"map_d {image.name}"] if material.has_alpha else [])]
    return "\n".join((*lines, "", ""))


def _has_uvs(mesh: Mesh) -> bool:
    return len(mesh.uvs) == len(mesh.render_vertices) and bool(np.any(mesh.uvs))


def _lines(mesh: Mesh, vertices: NDArray[np.floating], *, has_texture: bool) -> Iterator[str]:
    yield f"# {len(vertices)} vertices, {len(mesh.triangles)} triangles"
    if mesh.vertex_colours is None:
        yield from (f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in vertices.tolist())
    else:
        rows = np.column_stack([vertices, mesh.vertex_colours]).tolist()
        yield from (f"v {x:.5f} {y:.5f} {z:.5f} {r:.4f} {g:.4f} {b:.4f}" for x, y, z, r, g, b in rows)
    has_uvs = _has_uvs(mesh)
    if has_uvs:
        yield from (f"vt {u:.6f} {v:.6f}" for u, v in mesh.uvs.tolist())
    for name, triangles in group_triangles(mesh):
        yield f"g {name}"
        numbers = mesh.materials_of_triangles()[triangles]
        for number in np.unique(numbers).tolist():
            if number >= 0:
                yield f"usemtl material_{number}"
            elif has_texture:
                yield f"usemtl {BLENDED_MATERIAL if material_of(name).blended else OPAQUE_MATERIAL}"
            rows = triangles[numbers == number]
            corners = mesh.triangles[rows] + 1
            if has_uvs:
                pairs = np.stack([corners, mesh.render_triangles[rows] + 1], axis=2).tolist()
                yield from ("f " + " ".join(f"{v}/{t}" for v, t in face) for face in pairs)
            else:
                yield from (f"f {a} {b} {c}" for a, b, c in corners.tolist())
