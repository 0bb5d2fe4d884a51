"""Materials of meshes, and the MTL libraries of OBJ files with references to images as people write them.

Source: Wavefront, "MTL material format", appendix of the Advanced Visualizer manual, 1995.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError
from conf.face.formats.text import decode_name, read_lines

_IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tga", ".tif", ".tiff")
_IMAGE_FOLDERS = ("textures", "texture", "tex", "maps", "images", "materials")  # below the mesh's folder
_MAX_ENTRIES = 10_000  # of a folder, that are compared with a name in another case
_MAX_MATERIALS = 1000
_MAX_NOTES = 5
# Options of a texture reference with their number of values; -o, -s and -t take one to three numbers.
_OPTIONS = {
    **dict.fromkeys(("blendu", "blendv", "cc", "clamp", "texres", "bm", "boost", "imfchan", "type"), 1),
    "mm": 2,
}
_VECTOR_OPTIONS = ("o", "s", "t")


@dataclass(frozen=True, eq=False)
class MeshMaterial:
    """How the triangles of one material are coloured.

    image : image file, or (h, w, 4) uint8 sRGB with alpha, the top row first, or None
    alpha_image : file whose alpha, or brightness if it has none, is the alpha of the image, or None
    colour : sRGB, 0 to 1; multiplies the image
    alpha : 0 to 1, of the whole material
    has_alpha : the alpha of the image is coverage; None if the file does not say so
    uv_scale, uv_offset : from texture coordinates to those of the image
    """

    image: Path | NDArray[np.uint8] | None = None
    alpha_image: Path | None = None
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)
    alpha: float = 1.0
    has_alpha: bool | None = None
    uv_scale: tuple[float, float] = (1.0, 1.0)
    uv_offset: tuple[float, float] = (0.0, 0.0)


def read_material_libraries(mesh_path: Path, references: Iterable[str], notes: list[str]) -> dict[str, MeshMaterial]:
    """Return the materials of the libraries that an OBJ file names; append what is missing to the notes.

    references : the arguments of its `mtllib` lines, each one name or several
    """
    materials: dict[str, MeshMaterial] = {}
    folders = [mesh_path.parent]
    for reference in references:
        whole = find_file(reference, folders)
        names = [reference] if whole is not None else reference.split()
        for name in names:
            path = whole or find_file(name, folders) or find_file(mesh_path.with_suffix(".mtl").name, folders)
            if path is None:
                notes.append(f"the material library {name} was not found beside the mesh")
                continue
            for material, value in _read_library(path, mesh_path.parent, notes).items():
                materials.setdefault(material, value)
    return materials


def find_file(reference: str, folders: Iterable[Path]) -> Path | None:
    """Return the existing file that a reference in a mesh file means, or None.

    Tried in each folder: the path as written, its base name, its base name in the usual folders of textures; each in
    any case of letters, and images with another suffix.
    """
    name = reference.strip().strip("\"'").removeprefix("file://").replace("\\", "/")
    if not name or "\0" in name:
        return None
    as_bytes = name.encode("latin-1", "ignore").decode("utf-8", "surrogateescape")  # as files are named after unzipping
    names = dict.fromkeys((name, unquote(name), as_bytes))
    try:
        for folder in folders:
            for text in names:
                base = text.rsplit("/", 1)[-1]
                candidates = (folder / text, folder / base, *(folder / sub / base for sub in _IMAGE_FOLDERS))
                found = next((path for path in candidates if path.is_file()), None)
                found = found or next(filter(None, map(_in_any_case, candidates[1:])), None)
                if found is not None:
                    return found
    except (OSError, ValueError):
        return None
    return None


def _in_any_case(path: Path) -> Path | None:
    """Return the file of the path's folder whose name differs in case only, or in the suffix of an image only."""
    if not path.parent.is_dir():
        return None
    entries: dict[str, Path] = {}
    for count, entry in enumerate(path.parent.iterdir()):
        if count == _MAX_ENTRIES:
            break
        entries.setdefault(entry.name.casefold(), entry)
    names = [path.name.casefold()]
    if path.suffix.lower() in _IMAGE_SUFFIXES:
        names += [path.stem.casefold() + suffix for suffix in _IMAGE_SUFFIXES]
    return next((entries[name] for name in names if name in entries and entries[name].is_file()), None)


def _read_library(path: Path, mesh_folder: Path, notes: list[str]) -> dict[str, MeshMaterial]:
    materials: dict[str, MeshMaterial] = {}
    folders = list(dict.fromkeys((path.parent, mesh_folder)))
    name: str | None = None
    try:
        for _, line in read_lines(path):
            keyword, _, rest = decode_name(line).strip().replace("\t", " ").partition(" ")
            if keyword.lower() == "newmtl":
                name = rest.strip()
                if len(materials) < _MAX_MATERIALS:
                    materials[name] = MeshMaterial()
            elif keyword and not keyword.startswith("#"):
                # Statements before the first newmtl belong to a material without a name.
                material = materials.get(name or "", MeshMaterial())
                changed = _with_statement(material, keyword.lower(), rest.strip(), path, folders, notes)
                if changed is not material and len(materials) < _MAX_MATERIALS:
                    materials[name or ""] = changed
    except FileFormatError as error:
        notes.append(f"the material library {path.name} cannot be read")
        if error.line is None:
            return {}
    return materials


def _with_statement(
    material: MeshMaterial, keyword: str, rest: str, library: Path, folders: list[Path], notes: list[str]
) -> MeshMaterial:
    """Return the material after one statement of an MTL file."""
    if keyword in ("map_kd", "map_d"):
        name, options = _split_options(rest)
        path = find_file(name, folders)
        if path is None or path.suffix.lower() not in _IMAGE_SUFFIXES:
            what = "was not found: put it beside the mesh"
            if path is not None:
                what = f"cannot be read: convert it to PNG and name that in {library.name}"
            note = f"the image {name} {what}"
            if name and note not in notes and len(notes) < _MAX_NOTES:
                notes.append(note)
            return material
        if keyword == "map_d":
            return replace(material, alpha_image=path, has_alpha=True)
        scale, offset = options.get("s", (1.0, 1.0)), options.get("o", (0.0, 0.0))
        return replace(material, image=path, uv_scale=scale, uv_offset=offset)
    numbers = list(_leading_numbers(rest.split()))
    if keyword == "kd" and numbers:
        red, green, blue = numbers[:3] if len(numbers) > 2 else numbers[:1] * 3
        return replace(material, colour=(_unit(red), _unit(green), _unit(blue)))
    if keyword == "d" and (numbers or rest.startswith("-halo")):
        values = numbers or list(_leading_numbers(rest.split()[1:]))
        return replace(material, alpha=_unit(values[0])) if values else material
    if keyword == "tr" and numbers and material.alpha == 1.0:
        # Some programs write `Tr 1` for an opaque material.
        return replace(material, alpha=1.0 if numbers[0] >= 1.0 else _unit(1.0 - numbers[0]))
    return material


def _split_options(text: str) -> tuple[str, dict[str, tuple[float, float]]]:
    """Return the file name of a texture reference, and u and v of its options `-s` and `-o`."""
    words, options = text.split(), {}
    while len(words) > 1 and words[0].startswith("-"):
        option = words[0][1:].lower()
        if option in _VECTOR_OPTIONS:
            numbers = list(_leading_numbers(words[1:4]))
            if not numbers or len(numbers) == len(words) - 1:  # the last word is the name, though it is a number
                numbers = numbers[: len(words) - 2]
            default = 1.0 if option == "s" else 0.0
            u, v = (*numbers, default, default)[:2]
            options[option] = (u, v)
            words = words[1 + len(numbers) :]
        elif option in _OPTIONS:
            words = words[1 + _OPTIONS[option] :]
        else:
            break
    # Rejoin from the text itself, so that runs of blanks within a file name survive.
    name = text
    for _ in range(len(text.split()) - len(words)):
        name = name.lstrip().partition(" ")[2]
    return name.strip(), options


def _leading_numbers(words: Iterable[str]) -> Iterator[float]:
    for word in words:
        try:
            number = float(word.replace(",", "."))
        except ValueError:
            return
        if not abs(number) <= 1e6:  # also nan
            return
        yield number


def _unit(value: float) -> float:
    return min(max(value, 0.0), 1.0)
