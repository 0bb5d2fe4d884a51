"""Read PLY, STL, GLB, VRM and glTF meshes with trimesh."""

import io
import logging
import struct
import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from conf.errors import FileFormatError
from conf.face.formats.gltf import plain_gltf
from conf.face.formats.mtl import MeshMaterial, find_file
from conf.face.formats.obj import DEFAULT_GROUP, MAX_TRIANGLES, MAX_VERTICES, RawMesh, drop_unusable, with_materials
from conf.face.formats.repair import repair
from conf.face.formats.text import check_file

# What trimesh's and Pillow's readers raise for damaged files.
_READ_ERRORS = (
    *(ArithmeticError, AssertionError, AttributeError, BufferError, EOFError, ImportError, LookupError, MemoryError),
    *(NameError, OSError, RuntimeError, SyntaxError, TypeError, ValueError, Warning, struct.error),
)
_GLTF_SUFFIXES = (".glb", ".vrm", ".gltf")
_MAX_IMAGE_PIXELS = 1 << 26  # of an embedded image, 8192 x 8192
_MAX_PARTS = 10_000


def read_with_trimesh(path: Path, /) -> RawMesh:
    """Read a mesh; parts become groups, vertices keep the file's order.

    Images inside the file, colours of materials and vertex colours are read too.
    Raises FileFormatError if the file cannot be read as a mesh.
    """
    check_file(path)
    suffix = path.suffix.lower()
    is_gltf = suffix in _GLTF_SUFFIXES
    resolver = _Resolver(path.parent)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            kind, is_linear, notes = suffix[1:], False, list[str]()
            data = repair(kind, path.read_bytes(), notes)
            if is_gltf:
                kind, data, is_linear, notes = plain_gltf(path, data, resolver.get)
            scene = trimesh.load_scene(
                io.BytesIO(data), file_type=kind, process=False, maintain_order=True, resolver=resolver
            )
            notes += [f"the image {name} was not found: put it beside the mesh" for name in resolver.missing]
            if len(scene.graph.nodes_geometry) > _MAX_PARTS:
                raise FileFormatError(path, None, f"expected at most {_MAX_PARTS} parts")
            _check_size(path, (scene.geometry[scene.graph[node][1]] for node in scene.graph.nodes_geometry))
            parts = scene.dump()
            return _join(
                path,
                [part for part in parts if isinstance(part, trimesh.Trimesh) and len(part.faces)],
                notes,
                is_linear=is_linear,
            )
    except FileFormatError:
        raise
    except _READ_ERRORS as error:
        if is_gltf and resolver.missing:
            message = f"names the file {resolver.missing[0]}, which was not found beside it: copy all files of the mesh"
            raise FileFormatError(path, None, message) from error
        if is_gltf:
            raise FileFormatError(path, None, "expected a GLB mesh, found a damaged one: export it again") from error
        raise FileFormatError(path, None, f"expected a {kind.upper()} mesh, found something else") from error


class _Resolver(trimesh.resolvers.Resolver):
    """Opens the buffers and images that a glTF or PLY file names, in the file's folder only."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.missing: list[str] = []

    def get(self, key: str) -> bytes:
        """Return the bytes of a file. Raises FileNotFoundError."""
        path = find_file(key, [self._folder])
        if path is None:
            self.missing.append(key[:200])
            raise FileNotFoundError(key)
        check_file(path)
        return path.read_bytes()

    def write(self, name: str, data: Any) -> None:
        """Raise NotImplementedError: nothing is written."""
        raise NotImplementedError

    def namespaced(self, namespace: str) -> "_Resolver":
        """Return the resolver of a folder below this one."""
        return _Resolver(self._folder / namespace)

    def keys(self) -> list[str]:
        """Return no names: files are looked for when they are named."""
        return []


def _check_size(path: Path, parts: Iterable[Any]) -> None:
    vertices = triangles = 0
    for part in parts:
        vertices += len(getattr(part, "vertices", ()))
        triangles += len(getattr(part, "faces", ()))
        if vertices > MAX_VERTICES or triangles > MAX_TRIANGLES:
            message = f"expected at most {MAX_VERTICES} vertices and {MAX_TRIANGLES} triangles"
            raise FileFormatError(path, None, message)


def _join(path: Path, parts: list[trimesh.Trimesh], notes: list[str], *, is_linear: bool) -> RawMesh:
    if not parts:
        raise FileFormatError(path, None, "expected a mesh with triangles, found only points or lines")
    positions = np.concatenate([np.asarray(part.vertices, dtype=np.float64) for part in parts])
    triangles = [np.asarray(part.faces, dtype=np.int64) for part in parts]
    if positions.shape[1:] != (3,) or any(t.shape[1:] != (3,) for t in triangles):
        raise FileFormatError(path, None, "expected a mesh of triangles in three dimensions")
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    ends = np.cumsum([0, *(len(t) for t in triangles)])
    corners = np.concatenate([t + start for t, start in zip(triangles, starts, strict=False)])
    corners = np.stack([corners, corners], axis=-1)
    uvs = np.zeros((len(positions), 2))
    for i, part in enumerate(parts):
        uv = _uvs(part)
        if uv is None:
            corners[ends[i] : ends[i + 1], :, 1] = -1
        else:
            uvs[starts[i] : starts[i + 1]] = uv
    if (corners[..., 1] < 0).all():
        uvs = uvs[:0]
    kept = drop_unusable(path, positions, corners[..., 0], notes)
    if not np.ptp(positions, axis=0).any():
        raise FileFormatError(path, None, "expected a mesh, found all vertices at one position: export it again")
    numbering = np.cumsum(kept) - 1
    runs = {_group_name(part, i): slice(ends[i], ends[i + 1]) for i, part in enumerate(parts)}
    raw = RawMesh(
        positions=positions,
        uvs=uvs,
        corners=corners[kept],
        groups={name: numbering[run][kept[run]] for name, run in runs.items()},
        texture=None,
    )
    readings = _Materials(notes)
    numbers = np.repeat([readings.number_of(part) for part in parts], np.diff(ends)).astype(np.int32)[kept]
    colours = _vertex_colours(parts, starts, is_linear=is_linear)
    raw = with_materials(raw, tuple(readings.materials), numbers, colours)
    return RawMesh(**{**raw.__dict__, "notes": (*raw.notes, *notes)})


class _Materials:
    """The materials of the parts, each read once."""

    def __init__(self, notes: list[str]) -> None:
        self.materials: list[MeshMaterial] = []
        self._numbers: dict[int, int] = {}
        self._images: dict[int, NDArray[np.uint8] | None] = {}
        self._notes = notes

    def number_of(self, part: trimesh.Trimesh) -> int:
        """Return the index of the material of a part, -1 for none."""
        source = getattr(part.visual, "material", None)
        if source is None:
            return -1
        if id(source) not in self._numbers:
            self._numbers[id(source)] = len(self.materials)
            self.materials.append(self._read(source))
        return self._numbers[id(source)]

    def _read(self, source: Any) -> MeshMaterial:
        image = getattr(source, "baseColorTexture", None)
        image = getattr(source, "image", None) if image is None else image
        factor = getattr(source, "baseColorFactor", None)
        is_pbr = hasattr(source, "baseColorTexture")
        if not is_pbr:
            factor = getattr(source, "diffuse", None)
        mode = getattr(source, "alphaMode", None) or "OPAQUE"
        pixels = None if image is None else self._pixels(image)
        colour, alpha = (1.0, 1.0, 1.0), 1.0
        if factor is not None and len(factor) in (3, 4):
            values = np.asarray(factor, np.float64) / (255.0 if np.asarray(factor).dtype.kind in "iu" else 1.0)
            values = np.clip(np.nan_to_num(values, nan=1.0), 0.0, 1.0)
            red, green, blue = linear_to_srgb(values[:3]).tolist() if is_pbr else values[:3].tolist()
            colour, alpha = (red, green, blue), float(values[3]) if len(values) == 4 else 1.0
        if is_pbr and mode == "OPAQUE":
            alpha = 1.0
            if pixels is not None:
                pixels[..., 3] = 255
        elif mode == "MASK":
            cutoff = getattr(source, "alphaCutoff", None)
            cutoff, alpha = 0.5 if cutoff is None else float(cutoff), 1.0
            if pixels is not None:
                pixels[..., 3] = np.where(pixels[..., 3] >= 255 * cutoff, 255, 0)
        return MeshMaterial(image=pixels, colour=colour, alpha=alpha, has_alpha=mode in ("BLEND", "MASK"))

    def _pixels(self, image: Any) -> NDArray[np.uint8] | None:
        """Return an image of Pillow as (h, w, 4), or None with a note if it is damaged or too large."""
        try:
            width, height = image.size
            if width * height > _MAX_IMAGE_PIXELS:
                self._notes.append(
                    f"an image of {width} x {height} pixels inside the file is too large: it is not used"
                )
                return None
            return np.array(image.convert("RGBA"), dtype=np.uint8)
        except (*_READ_ERRORS, Exception) as error:
            self._notes.append(f"an image inside the file cannot be read ({error}): it is not used")
            return None


def linear_to_srgb(values: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return sRGB values, 0 to 1, of linear ones. Source: IEC 61966-2-1."""
    low = values * 12.92
    return np.asarray(np.where(values <= 0.0031308, low, 1.055 * np.maximum(values, 0.0031308) ** (1 / 2.4) - 0.055))


def _vertex_colours(
    parts: list[trimesh.Trimesh], starts: NDArray[np.int64], *, is_linear: bool
) -> NDArray[np.float32] | None:
    """Return (V, 3) sRGB colours, or None if no part has any. Colours of glTF are linear."""
    colours = np.ones((int(starts[-1]), 3), np.float32)
    found = False
    for i, part in enumerate(parts):
        own = _colours_of(part)
        if own is None or np.shape(own)[0] != len(part.vertices) or np.ndim(own) != 2 or np.shape(own)[1] < 3:
            continue
        values = np.asarray(own, np.float64)[:, :3] / (255.0 if np.asarray(own).dtype == np.uint8 else 1.0)
        values = np.clip(np.nan_to_num(values, nan=1.0), 0.0, 1.0)
        colours[starts[i] : starts[i + 1]] = linear_to_srgb(values) if is_linear else values
        found = True
    return colours if found else None


def _colours_of(part: trimesh.Trimesh) -> Any:
    visual: Any = part.visual
    if visual.kind == "vertex":
        return visual.vertex_colors
    if visual.kind == "face":
        sums = np.zeros((len(part.vertices), 4))
        np.add.at(sums, part.faces.ravel(), np.repeat(np.asarray(visual.face_colors, np.float64), 3, axis=0))
        counts = np.bincount(part.faces.ravel(), minlength=len(part.vertices))[:, None]
        return (sums / np.maximum(counts, 1)).astype(np.uint8)
    return getattr(visual, "vertex_attributes", {}).get("color")


def _uvs(part: trimesh.Trimesh) -> np.ndarray | None:
    uv = getattr(part.visual, "uv", None)
    usable = uv is not None and np.shape(uv) == (len(part.vertices), 2) and np.isfinite(uv).all()
    return np.asarray(uv, dtype=np.float64) if usable else None


def _group_name(part: trimesh.Trimesh, index: int) -> str:
    return f"{part.metadata.get('name', DEFAULT_GROUP)}{f'_{index}' if index else ''}"


logging.getLogger("trimesh").addHandler(logging.NullHandler())
