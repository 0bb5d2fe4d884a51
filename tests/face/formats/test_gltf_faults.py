"""GLB and glTF as other programs write them, damaged or compressed, each with what must be read or said."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from conf.errors import FileFormatError
from conf.face.mesh.mesh import load_mesh
from tests.face.formats.test_mesh_faults import material_of, read


def glb(**changes: object) -> bytes:
    """Return a box as GLB with other entries of its JSON."""
    data = trimesh.creation.box().export(file_type="glb")
    size = int.from_bytes(data[12:16], "little")
    text = json.dumps(json.loads(data[20 : 20 + size]) | changes).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + size :]
    length = (20 + len(text) + len(rest)).to_bytes(4, "little")
    return data[:8] + length + len(text).to_bytes(4, "little") + b"JSON" + text + rest


@pytest.mark.parametrize(
    ("name", "advice"),
    [
        ("KHR_draco_mesh_compression", "export it without Draco compression"),
        ("EXT_meshopt_compression", "export it without mesh compression"),
    ],
)
def test_a_required_compression_is_named_with_what_to_do(tmp_path: Path, name: str, advice: str) -> None:
    with pytest.raises(FileFormatError, match=f"requires {name}, which is not supported: {advice}"):
        read(tmp_path, glb(extensionsRequired=[name]), name="face.glb")


def test_other_required_extensions_and_vrm_are_read(tmp_path: Path) -> None:
    data = glb(extensionsRequired=["KHR_materials_unlit"], extensionsUsed=["KHR_materials_unlit"])
    assert len(read(tmp_path, data, name="face.glb").triangles) == 12
    assert len(read(tmp_path, data, name="face.VRM").triangles) == 12


def test_a_compressed_mesh_that_is_not_declared_is_refused_too(tmp_path: Path) -> None:
    accessor = {"componentType": 5126, "count": 8, "type": "VEC3"}
    extensions = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
    primitive = {"attributes": {"POSITION": 0}, "extensions": extensions}
    data = glb(accessors=[accessor], meshes=[{"primitives": [primitive]}])
    with pytest.raises(FileFormatError, match="requires KHR_draco_mesh_compression"):
        read(tmp_path, data, name="face.glb")


@pytest.mark.parametrize("name", ["face.glb", "face.gltf", "face.vrm"])
def test_glb_and_gltf_are_told_apart_by_their_bytes(tmp_path: Path, name: str) -> None:
    assert len(read(tmp_path, glb(), name=name).triangles) == 12
    for file, data in trimesh.exchange.gltf.export_gltf(trimesh.Scene(trimesh.creation.box())).items():
        (tmp_path / file.replace("model.gltf", name)).write_bytes(data)
    assert len(load_mesh(tmp_path / name).triangles) == 12


def test_gltf_is_read_with_its_buffers_beside_it(tmp_path: Path) -> None:
    for name, data in trimesh.exchange.gltf.export_gltf(trimesh.Scene(trimesh.creation.box())).items():
        (tmp_path / name.replace("model.gltf", "face.gltf")).write_bytes(data)
    assert len(load_mesh(tmp_path / "face.gltf").triangles) == 12
    for path in tmp_path.glob("*.bin"):
        path.unlink()
    with pytest.raises(FileFormatError, match=r"face\.gltf: names the file \S+\.bin, which was not found beside it"):
        load_mesh(tmp_path / "face.gltf")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (glb()[:-100], r"expected a GLB mesh of \d+ bytes, found only \d+ of them: copy or download it again"),
        (glb()[:10], "expected a GLB mesh, found only 10 bytes"),
        (glb().replace(b"{", b"[", 1), "expected a GLB mesh, found a damaged one: export it again"),
        (glb(accessors=[{"componentType": 5126, "count": 8, "type": "VEC2", "bufferView": 0}] * 9), "expected"),
        (glb(accessors=[{"componentType": 5126, "count": 10**12, "type": "VEC3"}] * 9), "expected at most"),
        (glb(accessors=[]), "expected a GLB mesh, found a damaged one: export it again"),
        (b"hello, this is no mesh at all", "expected a GLB or glTF mesh, found something else"),
        (glb(asset={"version": "1.0"}), "expected a glTF of version 2, found version 1: convert it"),
    ],
)
def test_a_damaged_glb_has_its_own_message(tmp_path: Path, data: bytes, message: str) -> None:
    with pytest.raises(FileFormatError, match=message):
        read(tmp_path, data, name="face.glb")


def test_an_image_inside_a_glb_is_used(tmp_path: Path) -> None:
    box = trimesh.creation.box()
    image = Image.new("RGB", (4, 4), (90, 60, 40))
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=image, baseColorFactor=[1.0, 0.5, 1.0, 1.0])
    box.visual = trimesh.visual.TextureVisuals(uv=np.zeros((8, 2)), material=material)
    box.export(tmp_path / "face.glb")
    found = material_of(load_mesh(tmp_path / "face.glb"), 0)
    assert isinstance(found.image, np.ndarray) and found.image[0, 0].tolist() == [90, 60, 40, 255]
    assert found.colour == pytest.approx((1.0, 0.7354, 1.0), abs=0.01)  # the file's colour is linear


@pytest.mark.parametrize(("mode", "alpha"), [("OPAQUE", [255, 255]), ("BLEND", [100, 200]), ("MASK", [0, 255])])
def test_the_alpha_mode_of_a_glb_counts(tmp_path: Path, mode: str, alpha: list[int]) -> None:
    image = Image.fromarray(np.array([[[9, 9, 9, 100], [9, 9, 9, 200]]], np.uint8))
    box = trimesh.creation.box()
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=image, alphaMode=mode, alphaCutoff=0.5)
    box.visual = trimesh.visual.TextureVisuals(uv=np.zeros((8, 2)), material=material)
    box.export(tmp_path / "face.glb")
    found = material_of(load_mesh(tmp_path / "face.glb"), 0)
    assert isinstance(found.image, np.ndarray) and found.image[0, :, 3].tolist() == alpha
    assert found.has_alpha is (mode != "OPAQUE")


def test_vertex_colours_of_glb_that_are_no_bytes_are_linear(tmp_path: Path) -> None:
    box = trimesh.creation.box()
    box.vertex_attributes["color"] = np.tile(np.array([0.2, 0.1, 0.0, 1.0], np.float32), (8, 1))
    box.vertex_attributes["color"][0] = 1.0
    linear = box.vertex_attributes.pop("color")
    data = box.export(file_type="glb")
    size = int.from_bytes(data[12:16], "little")
    header = json.loads(data[20 : 20 + size])
    view = {"buffer": 0, "byteOffset": header["buffers"][0]["byteLength"], "byteLength": linear.nbytes}
    header["buffers"][0]["byteLength"] += linear.nbytes
    header["bufferViews"].append(view)
    accessor = {"bufferView": len(header["bufferViews"]) - 1, "componentType": 5126, "count": 8, "type": "VEC4"}
    header["accessors"].append(accessor)
    header["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = len(header["accessors"]) - 1
    binary = data[28 + size :] + linear.tobytes()
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    chunks = len(text).to_bytes(4, "little") + b"JSON" + text + len(binary).to_bytes(4, "little") + b"BIN\0" + binary
    mesh = read(tmp_path, data[:8] + (12 + len(chunks)).to_bytes(4, "little") + chunks, name="face.glb")
    assert mesh.vertex_colours is not None
    assert mesh.vertex_colours[3] == pytest.approx([0.4845, 0.3492, 0.0], abs=0.02)
