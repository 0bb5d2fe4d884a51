"""Check glTF and GLB files, and rewrite into plain glTF 2.0 what trimesh passes over silently.

Rewritten are positions and texture coordinates in normalised integers (KHR_mesh_quantization) or sparse accessors,
KHR_texture_transform, a second set of texture coordinates, KHR_materials_pbrSpecularGlossiness, and files without a
scene. Source: Khronos Group, "glTF 2.0 Specification", 2021, and its extensions.
"""

import base64
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError
from conf.face.formats.obj import MAX_TRIANGLES

_GLB_HEADER = struct.Struct("<4sII")
_GLB_CHUNK = struct.Struct("<I4s")
_DTYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_FLOAT = 5126
_IMAGE_STARTS = (b"\x89PNG", b"\xff\xd8", b"RIFF", b"GIF8", b"BM")
_SPECULAR_GLOSSINESS = "KHR_materials_pbrSpecularGlossiness"
_TRANSFORM = "KHR_texture_transform"
_UNSIGNED_BYTE = 5121  # of OpenGL
# Extensions without which the vertices cannot be read, and how to write the file without them.
_COMPRESSION = {
    "KHR_draco_mesh_compression": "export it without Draco compression (in Blender: Data, Compression off)",
    "EXT_meshopt_compression": "export it without mesh compression (meshopt)",
    "KHR_meshopt_compression": "export it without mesh compression (meshopt)",
}


def plain_gltf(path: Path, data: bytes, load: Callable[[str], bytes], /) -> tuple[str, bytes, bool, list[str]]:
    """Check a file and rewrite what only some readers understand.

    load : returns the bytes of a file beside it, or raises OSError
    Returns "glb" or "gltf" whatever its suffix, the plain file, whether its vertex colours are linear, and notes. By
    the standard they are, but programs that write bytes write sRGB there: linear bytes would band in the dark.
    Raises FileFormatError for a file that is no glTF, damaged, or compressed in a way that cannot be read; OSError.
    """
    is_binary = data[:4] == b"glTF"
    text = _glb_json(path, data) if is_binary else data
    try:
        header = json.loads(text.decode("utf-8-sig"))
        version = int(float(header["asset"]["version"]))
    except (ValueError, KeyError, TypeError, RecursionError, OverflowError) as error:
        message = "expected a GLB mesh, found a damaged one: export it again"
        if not is_binary:
            message = "expected a GLB or glTF mesh, found something else"
        raise FileFormatError(path, None, message) from error
    if version != 2:
        raise FileFormatError(path, None, f"expected a glTF of version 2, found version {version}: convert it")
    try:
        accessors, primitives = header.get("accessors", []), _primitives(header)
        for name, advice in _COMPRESSION.items():
            uses = any(
                name in primitive.get("extensions", {})
                and "bufferView" not in accessors[primitive["attributes"]["POSITION"]]
                for primitive in primitives
            )
            if uses or name in header.get("extensionsRequired", []):
                raise FileFormatError(path, None, f"requires {name}, which is not supported: {advice}")
        if sum(int(accessor["count"]) for accessor in accessors if "bufferView" not in accessor) > 3 * MAX_TRIANGLES:
            raise FileFormatError(path, None, f"expected at most {MAX_TRIANGLES} triangles")
        colours = [primitive["attributes"].get("COLOR_0") for primitive in primitives]
        types = {accessors[number]["componentType"] for number in colours if number is not None}
        rewriting = _Rewriting(header, _glb_binary(data) if is_binary else b"", load)
        rewriting.run()
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise FileFormatError(path, None, "expected a GLB mesh, found a damaged one: export it again") from error
    plain = rewriting.result()
    if plain is not None:
        data = _with_json(data, plain) if is_binary else plain
    return "glb" if is_binary else "gltf", data, types != {_UNSIGNED_BYTE}, rewriting.notes


def _primitives(header: Any) -> list[Any]:
    return [primitive for mesh in header.get("meshes", []) for primitive in mesh["primitives"]]


def _glb_json(path: Path, data: bytes) -> bytes:
    """Return the JSON of a GLB file. Raises FileFormatError if it ends too early."""
    if len(data) < _GLB_HEADER.size + _GLB_CHUNK.size:
        raise FileFormatError(path, None, f"expected a GLB mesh, found only {len(data)} bytes: copy it again")
    _, version, length = _GLB_HEADER.unpack_from(data)
    if version == 2 and length > len(data):
        message = f"expected a GLB mesh of {length} bytes, found only {len(data)} of them: copy or download it again"
        raise FileFormatError(path, None, message)
    size, kind = _GLB_CHUNK.unpack_from(data, _GLB_HEADER.size)
    start = _GLB_HEADER.size + _GLB_CHUNK.size
    if version == 2 and (kind != b"JSON" or start + size > len(data)):
        raise FileFormatError(path, None, "expected a GLB mesh, found a damaged one: export it again")
    return data[start : start + size] if version == 2 else b'{"asset": {"version": "%d"}}' % version


def _glb_binary(data: bytes) -> bytes:
    """Return the binary chunk of a GLB file whose JSON chunk is whole, or nothing."""
    size, _ = _GLB_CHUNK.unpack_from(data, _GLB_HEADER.size)
    start = _GLB_HEADER.size + _GLB_CHUNK.size + size
    if start + _GLB_CHUNK.size > len(data):
        return b""
    length, _ = _GLB_CHUNK.unpack_from(data, start)
    return data[start + _GLB_CHUNK.size : start + _GLB_CHUNK.size + length]


def _with_json(data: bytes, text: bytes) -> bytes:
    """Return a GLB file with another JSON chunk."""
    size, kind = _GLB_CHUNK.unpack_from(data, _GLB_HEADER.size)
    rest = data[_GLB_HEADER.size + _GLB_CHUNK.size + size :]
    text += b" " * (-len(text) % 4)
    length = _GLB_HEADER.size + _GLB_CHUNK.size + len(text) + len(rest)
    return _GLB_HEADER.pack(b"glTF", 2, length) + _GLB_CHUNK.pack(len(text), kind) + text + rest


class _Rewriting:
    """Changes the JSON of a file; new arrays go into a buffer of their own."""

    def __init__(self, header: Any, binary: bytes, load: Callable[[str], bytes]) -> None:
        self.notes: list[str] = []
        self._header = header
        self._binary = binary
        self._load = load
        self._buffers: dict[int, bytes] = {}
        self._new_bytes = bytearray()
        self._is_changed = False

    def run(self) -> None:
        """Rewrite. Raises LookupError, TypeError, ValueError, ArithmeticError or AttributeError for a damaged file."""
        self._add_scene()
        for material in self._header.get("materials", []):
            self._use_diffuse_colour(material)
        for primitive in _primitives(self._header):
            self._rewrite_primitive(primitive)
        self._note_images()

    def result(self) -> bytes | None:
        """Return the new JSON, or None if the file is plain as it is."""
        if not self._is_changed:
            return None
        if self._new_bytes:
            uri = "data:application/octet-stream;base64," + base64.b64encode(self._new_bytes).decode("ascii")
            self._header.setdefault("buffers", []).append({"byteLength": len(self._new_bytes), "uri": uri})
        return json.dumps(self._header).encode()

    def _add_scene(self) -> None:
        header = self._header
        if header.get("meshes") and not header.get("nodes"):
            header["nodes"] = [{"mesh": i} for i in range(len(header["meshes"]))]
            header.pop("scenes", None)
        if header.get("nodes") and not header.get("scenes"):
            children = {child for node in header["nodes"] for child in node.get("children", [])}
            header["scenes"] = [{"nodes": [i for i in range(len(header["nodes"])) if i not in children]}]
            header["scene"] = 0
            self._is_changed = True

    def _use_diffuse_colour(self, material: Any) -> None:
        """Replace the specular-glossiness model, of which only the diffuse colour is drawn."""
        model = material.get("extensions", {}).pop(_SPECULAR_GLOSSINESS, None)
        if model is None:
            return
        names = {"baseColorFactor": "diffuseFactor", "baseColorTexture": "diffuseTexture"}
        base = {new: model[old] for new, old in names.items() if old in model}
        material["pbrMetallicRoughness"] = {**material.get("pbrMetallicRoughness", {}), **base}
        self._is_changed = True

    def _rewrite_primitive(self, primitive: Any) -> None:
        attributes, accessors = primitive["attributes"], self._header.get("accessors", [])
        if "POSITION" in attributes and _is_packed(accessors[attributes["POSITION"]]):
            attributes["POSITION"] = self._append(self._values(accessors[attributes["POSITION"]]))
        texture = self._base_texture(primitive)
        transform = texture.get("extensions", {}).get(_TRANSFORM, {})
        source = f"TEXCOORD_{int(transform.get('texCoord', texture.get('texCoord', 0)))}"
        if source not in attributes:
            return
        accessor = accessors[attributes[source]]
        if source == "TEXCOORD_0" and not transform and not _is_packed(accessor):
            return
        attributes["TEXCOORD_0"] = self._append(_transformed(self._values(accessor)[:, :2], transform))

    def _base_texture(self, primitive: Any) -> Any:
        """Return the reference to the texture of a primitive, or an empty one."""
        number = primitive.get("material")
        material = {} if number is None else self._header["materials"][number]
        return material.get("pbrMetallicRoughness", {}).get("baseColorTexture", {})

    def _append(self, values: NDArray[np.float64]) -> int:
        """Add an array as an accessor of float32 and return its number."""
        header, data = self._header, np.ascontiguousarray(values, "<f4").tobytes()
        views, accessors = header.setdefault("bufferViews", []), header["accessors"]
        views.append(
            {"buffer": len(header.get("buffers", [])), "byteOffset": len(self._new_bytes), "byteLength": len(data)}
        )
        self._new_bytes += data
        kind = f"VEC{values.shape[1]}"
        accessors.append({"bufferView": len(views) - 1, "componentType": _FLOAT, "count": len(values), "type": kind})
        self._is_changed = True
        return len(accessors) - 1

    def _values(self, accessor: Any) -> NDArray[np.float64]:
        """Return the (count, columns) values of an accessor, normalised and with its sparse values."""
        count, columns = int(accessor["count"]), _COLUMNS[accessor["type"]]
        if "bufferView" in accessor:
            values = self._array(accessor, accessor["componentType"], count, columns).astype(np.float64)
        else:
            values = np.zeros((count, columns))
        sparse = accessor.get("sparse")
        if sparse:
            number = int(sparse["count"])
            rows = self._array(sparse["indices"], sparse["indices"]["componentType"], number, 1)[:, 0]
            values[rows] = self._array(sparse["values"], accessor["componentType"], number, columns)
        if accessor.get("normalized") and accessor["componentType"] != _FLOAT:
            values = np.maximum(values / np.iinfo(_DTYPES[accessor["componentType"]]).max, -1.0)
        return values

    def _array(self, reference: Any, component: int, rows: int, columns: int) -> NDArray[Any]:
        """Return (rows, columns) numbers of a buffer view, as they are stored."""
        view = self._header["bufferViews"][reference["bufferView"]]
        dtype = np.dtype(_DTYPES[component])
        start = int(view.get("byteOffset", 0)) + int(reference.get("byteOffset", 0))
        stride = int(view.get("byteStride", dtype.itemsize * columns))
        data = self._buffer(int(view["buffer"]))
        if min(start, rows, stride - dtype.itemsize * columns) < 0:
            raise ValueError("a buffer view outside its buffer")
        length = (rows - 1) * stride + dtype.itemsize * columns if rows else 0
        if start + length > len(data):
            raise ValueError("a buffer view outside its buffer")
        return np.ndarray((rows, columns), dtype, data, start, (stride, dtype.itemsize))

    def _buffer(self, number: int) -> bytes:
        if number not in self._buffers:
            uri = self._header["buffers"][number].get("uri")
            self._buffers[number] = self._binary if uri is None else self._bytes_of(uri)
        return self._buffers[number]

    def _bytes_of(self, uri: str) -> bytes:
        """Return the bytes of a file, or of a `data:` URI. Raises OSError, ValueError."""
        _, marker, text = uri.partition("base64,")
        return base64.b64decode(text) if marker else self._load(uri)

    def _note_images(self) -> None:
        """Note the images that are used and whose format cannot be read. trimesh passes over them silently."""
        textures, images = self._header.get("textures", []), self._header.get("images", [])
        used = {int(texture["index"]) for p in _primitives(self._header) if (texture := self._base_texture(p))}
        for texture in sorted(used):
            sources = [textures[texture].get("source")]
            sources += [other.get("source") for other in textures[texture].get("extensions", {}).values()]
            starts = [self._start_of(images[number]) for number in sources if number is not None]
            if starts and not any(start is None or start.startswith(_IMAGE_STARTS) for start in starts):
                what = "KTX2" if starts[0] and starts[0][1:4] == b"KTX" else "of an unknown format"
                self.notes.append(
                    f"an image of the file is {what}, which cannot be read: export it with PNG or JPEG textures"
                )

    def _start_of(self, image: Any) -> bytes | None:
        """Return the first bytes of an image, or None of one in a file beside this."""
        if "bufferView" in image:
            return self._array(image, 5121, 12, 1).tobytes()
        return self._bytes_of(image["uri"])[:12] if "base64," in image["uri"] else None


def _is_packed(accessor: Any) -> bool:
    """Return whether an accessor must be unpacked for readers that know plain ones only."""
    return bool("sparse" in accessor or (accessor.get("normalized") and accessor["componentType"] != _FLOAT))


def _transformed(uvs: NDArray[np.float64], transform: Any) -> NDArray[np.float64]:
    """Return texture coordinates (n, 2) after KHR_texture_transform."""
    angle = float(transform.get("rotation", 0.0))
    cos, sin = np.cos(angle), np.sin(angle)
    scaled = uvs * np.array(transform.get("scale", (1.0, 1.0)), np.float64)
    rotated = scaled @ np.array([[cos, -sin], [sin, cos]])
    return np.asarray(rotated + np.array(transform.get("offset", (0.0, 0.0)), np.float64))
