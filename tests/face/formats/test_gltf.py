"""glTF features that other readers pass over silently, each with the value that must be read."""

import base64
import json
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from conf.errors import FileFormatError
from conf.face.formats.gltf import plain_gltf
from conf.face.mesh.mesh import Mesh, load_mesh

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
CORNERS = np.array([0, 1, 2, 0, 2, 3], np.uint16)
UVS = SQUARE[:, :2].copy()
COMPONENTS = {"int8": 5120, "uint8": 5121, "uint16": 5123, "float32": 5126}
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}
Json = dict[str, Any]
PACKED: Json = {"bufferView": 1, "componentType": 5120, "count": 4, "type": "VEC3", "normalized": True}


def uri(data: bytes) -> str:
    return "data:application/octet-stream;base64," + base64.b64encode(data).decode()


def gltf(
    arrays: Sequence[NDArray[Any]], attributes: Json, *, accessors: Sequence[Json] = (), primitive: Json | None = None,
    **header: Any,
) -> Json:  # fmt: skip
    """Return the JSON of a mesh whose arrays are accessors 0, 1 ... in a buffer each; the indices are accessor 0.

    accessors : more entries for each accessor
    """
    entries = [
        {"bufferView": i, "componentType": COMPONENTS[str(a.dtype)], "count": len(a), "type": KINDS[a.size // len(a)]}
        for i, a in enumerate(arrays)
    ]
    for entry, more in zip(entries, accessors, strict=False):
        entry.update(more)
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": a.nbytes, "uri": uri(a.tobytes())} for a in arrays],
        "bufferViews": [{"buffer": i, "byteLength": a.nbytes} for i, a in enumerate(arrays)],
        "accessors": entries,
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 0, **(primitive or {})}]}],
        "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0,
    } | header  # fmt: skip


def read(tmp_path: Path, header: Json) -> Mesh:
    (tmp_path / "face.gltf").write_text(json.dumps(header))
    return load_mesh(tmp_path / "face.gltf")


def png() -> bytes:
    file = BytesIO()
    Image.new("RGB", (4, 4), (90, 60, 40)).save(file, "PNG")
    return file.getvalue()


def textured(image: Json, *, texture: Json | None = None, reference: Json | None = None, **options: Any) -> Json:
    """Return a square with a texture. reference : more entries of the material's reference to it."""
    base = {"baseColorTexture": {"index": 0, **(reference or {})}}
    return gltf(
        options.pop("arrays", (CORNERS, SQUARE, UVS)), options.pop("attributes", {"POSITION": 1, "TEXCOORD_0": 2}),
        primitive={"material": 0}, images=[image], textures=[texture or {"source": 0}],
        materials=[{"pbrMetallicRoughness": base}], **options,
    )  # fmt: skip


def test_normalised_positions_are_scaled(tmp_path: Path) -> None:
    packed = np.round(SQUARE * 127).astype(np.int8)
    header = gltf((CORNERS, packed), {"POSITION": 1}, accessors=({}, {"normalized": True}))
    header["nodes"] = [{"mesh": 0, "scale": [2, 2, 2], "translation": [5, 0, 0]}]
    assert read(tmp_path, header).vertices == pytest.approx(SQUARE * 2 + [5, 0, 0])


def test_normalised_texture_coordinates_are_scaled(tmp_path: Path) -> None:
    packed = np.round(UVS * 65535).astype(np.uint16)
    header = textured({"uri": uri(png())}, arrays=(CORNERS, SQUARE, packed), accessors=({}, {}, {"normalized": True}))
    mesh = read(tmp_path, header)
    assert mesh.uvs[mesh.render_triangles[0]] == pytest.approx(np.array([[0, 1], [1, 1], [1, 0]]))


def test_sparse_positions_replace_those_of_the_base(tmp_path: Path) -> None:
    new = np.array([[6, 0, 0], [3, 4, 5]], np.float32)
    header = gltf((CORNERS, SQUARE, np.array([1, 2], np.uint16), new), {"POSITION": 1})
    header["accessors"][1]["sparse"] = {
        "count": 2, "indices": {"bufferView": 2, "componentType": 5123}, "values": {"bufferView": 3},
    }  # fmt: skip
    assert read(tmp_path, header).vertices.tolist() == [[0, 0, 0], [6, 0, 0], [3, 4, 5], [0, 1, 0]]
    del header["accessors"][1]["bufferView"]
    assert read(tmp_path, header).vertices.tolist() == [[0, 0, 0], [6, 0, 0], [3, 4, 5], [0, 0, 0]]


def test_interleaved_arrays_are_read(tmp_path: Path) -> None:
    packed = np.zeros((4, 4), np.int8)
    packed[:, :3] = SQUARE * 127
    header = gltf((CORNERS, packed.reshape(-1)), {"POSITION": 1})
    header["accessors"][1] |= {"normalized": True, "count": 4, "type": "VEC3"}
    header["bufferViews"][1]["byteStride"] = 4
    assert read(tmp_path, header).vertices == pytest.approx(SQUARE)


@pytest.mark.parametrize(
    ("transform", "expected"),
    [
        ({"offset": [0.5, 0.25], "scale": [2, 4]}, [[0.5, 0.75], [2.5, 0.75], [2.5, -3.25]]),
        ({"rotation": np.pi / 2}, [[0, 1], [0, 2], [1, 2]]),
    ],
)
def test_a_texture_transform_moves_the_texture_coordinates(
    tmp_path: Path, transform: Json, expected: list[list[float]]
) -> None:
    mesh = read(tmp_path, textured({"uri": uri(png())}, reference={"extensions": {"KHR_texture_transform": transform}}))
    assert mesh.uvs[mesh.render_triangles[0]] == pytest.approx(np.array(expected))


def test_the_set_of_texture_coordinates_that_the_material_names_is_used(tmp_path: Path) -> None:
    header = textured(
        {"uri": uri(png())}, reference={"texCoord": 1}, arrays=(CORNERS, SQUARE, UVS, UVS / 2),
        attributes={"POSITION": 1, "TEXCOORD_0": 2, "TEXCOORD_1": 3},
    )  # fmt: skip
    mesh = read(tmp_path, header)
    assert mesh.uvs[mesh.render_triangles[0]] == pytest.approx(np.array([[0, 1], [0.5, 1], [0.5, 0.5]]))


@pytest.mark.parametrize("missing", [("scene", "scenes"), ("scene", "scenes", "nodes")])
def test_a_file_without_a_scene_shows_all_its_meshes(tmp_path: Path, missing: tuple[str, ...]) -> None:
    header = gltf((CORNERS, SQUARE), {"POSITION": 1})
    for key in missing:
        del header[key]
    assert read(tmp_path, header).vertices == pytest.approx(SQUARE)


def test_the_diffuse_colour_of_specular_glossiness_is_used(tmp_path: Path) -> None:
    model = {"diffuseFactor": [0.5, 0.2, 0.1, 1.0]}
    header = gltf(
        (CORNERS, SQUARE), {"POSITION": 1}, primitive={"material": 0},
        materials=[{"extensions": {"KHR_materials_pbrSpecularGlossiness": model}}],
    )  # fmt: skip
    assert read(tmp_path, header).materials[0].colour == pytest.approx((0.7366, 0.4845, 0.3525), abs=0.001)


@pytest.mark.parametrize(
    ("image", "texture", "note"),
    [
        ({"uri": "gone.png"}, None, "the image gone.png was not found: put it beside the mesh"),
        ({"uri": uri(b"\xabKTX 20\xbb\r\n\x1a\n" + bytes(80)), "mimeType": "image/ktx2"},
         {"extensions": {"KHR_texture_basisu": {"source": 0}}},
         "an image of the file is KTX2, which cannot be read: export it with PNG or JPEG textures"),
        ({"uri": uri(b"no image")}, None,
         "an image of the file is of an unknown format, which cannot be read: export it with PNG or JPEG textures"),
    ],
)  # fmt: skip
def test_a_texture_that_cannot_be_used_is_named(tmp_path: Path, image: Json, texture: Json | None, note: str) -> None:
    mesh = read(tmp_path, textured(image, texture=texture))
    assert mesh.notes == (note,) and not any(material.image is not None for material in mesh.materials)


@pytest.mark.parametrize("reference", ["my skin.png", "my%20skin.png", "textures/MY SKIN.PNG"])
def test_a_texture_beside_the_file_is_found(tmp_path: Path, reference: str) -> None:
    (tmp_path / "my skin.png").write_bytes(png())
    mesh = read(tmp_path, textured({"uri": reference}))
    image = mesh.materials[0].image
    assert isinstance(image, np.ndarray) and image[0, 0].tolist() == [90, 60, 40, 255] and mesh.notes == ()


@pytest.mark.parametrize(
    "change",
    [
        {"accessors": [PACKED | {"bufferView": 9}] * 2},
        {"accessors": [PACKED | {"componentType": 1}] * 2},
        {"accessors": [PACKED | {"count": 9**9}] * 2},
        {"accessors": [PACKED | {"count": -4}] * 2},
        {"bufferViews": [{"buffer": 1, "byteOffset": -1, "byteLength": 9}] * 2},
        {"materials": 7}, {"nodes": [], "scenes": [], "meshes": {"a": 1}},
    ],
)  # fmt: skip
def test_a_damaged_file_is_refused_in_one_sentence(tmp_path: Path, change: Json) -> None:
    packed = (SQUARE * 127).astype(np.int8)
    header = gltf((CORNERS, packed), {"POSITION": 1}, accessors=({}, {"normalized": True})) | change
    with pytest.raises(FileFormatError, match="expected a GLB mesh, found a damaged one: export it again"):
        read(tmp_path, header)


def test_a_plain_file_is_returned_as_it_is(tmp_path: Path) -> None:
    data = json.dumps(gltf((CORNERS, SQUARE), {"POSITION": 1})).encode()
    assert plain_gltf(tmp_path / "a.gltf", data, lambda name: b"")[:2] == ("gltf", data)
