"""Meshes as other programs write them, each with the value that must be read. Every file is made here."""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from conf.errors import FileFormatError
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.default_head import DEFAULT_HEAD
from conf.face.formats.dpc import MotionClip, read_dpc, write_dpc
from conf.face.formats.epc import read_epc
from conf.face.formats.mtl import MeshMaterial
from conf.face.formats.ppc import read_ppc
from conf.face.mesh.mesh import Mesh, load_mesh

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
UVS = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
TWO_FACES = "usemtl skin\nf 1/1 2/2 3/3\nusemtl eye\nf 1/1 3/3 4/4\n"
APART = "v 5 5 5\nv 6 5 5\nv 5 6 5\n"
BOM = b"\xef\xbb\xbf"


def png(path: Path, colour: tuple[int, ...] = (200, 100, 50), size: tuple[int, int] = (4, 4)) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.new("RGBA" if len(colour) == 4 else "RGB", size, colour).save(path)
    return path


def read(tmp_path: Path, text: str | bytes, library: str | None = None, name: str = "face.obj") -> Mesh:
    if library is not None:
        (tmp_path / "face.mtl").write_text(library)
        text = "mtllib face.mtl\n" + (text if isinstance(text, str) else text.decode())
    (tmp_path / name).write_bytes(text.encode() if isinstance(text, str) else text)
    return load_mesh(tmp_path / name)


def material_of(mesh: Mesh, triangle: int) -> MeshMaterial:
    return mesh.materials[mesh.materials_of_triangles()[triangle]]


# 9: materials by face


@pytest.mark.parametrize("first", ["skin", "eye"])
def test_each_face_has_the_texture_of_its_material(tmp_path: Path, first: str) -> None:
    png(tmp_path / "skin.png"), png(tmp_path / "eye.png")
    second = "skin" if first == "eye" else "eye"
    library = "".join(f"newmtl {name}\nmap_Kd {name}.png\n" for name in (first, second))
    mesh = read(tmp_path, SQUARE + UVS + TWO_FACES, library)
    assert [material_of(mesh, i).image for i in (0, 1)] == [tmp_path / "skin.png", tmp_path / "eye.png"]
    assert mesh.texture is None and mesh.notes == ()


def test_colour_and_alpha_belong_to_the_material(tmp_path: Path) -> None:
    png(tmp_path / "mask.png")
    library = "newmtl skin\nKd 0.4 0.2 0.1\nTr 0.25\nnewmtl eye\nKd 1 1 1\nd 0.5\nmap_d mask.png\n"
    mesh = read(tmp_path, SQUARE + UVS + TWO_FACES, library)
    skin, eye = material_of(mesh, 0), material_of(mesh, 1)
    assert skin.colour == (0.4, 0.2, 0.1) and skin.alpha == 0.75 and skin.image is None
    assert eye.alpha == 0.5 and eye.alpha_image == tmp_path / "mask.png"


def test_a_material_is_found_in_another_case_and_a_missing_one_is_named(tmp_path: Path) -> None:
    mesh = read(tmp_path, SQUARE + TWO_FACES.replace("/1", "").replace("/2", "").replace("/3", "").replace("/4", ""),
                "newmtl SKIN\nKd 1 0 0\n")  # fmt: skip
    assert material_of(mesh, 0).colour == (1.0, 0.0, 0.0)
    assert mesh.materials_of_triangles().tolist() == [0, -1]
    assert mesh.notes == ("the material eye is not in the material library",)


def test_a_scaled_texture_has_scaled_coordinates(tmp_path: Path) -> None:
    png(tmp_path / "skin.png")
    library = "newmtl skin\nmap_Kd -s 2 3 1 -o 0.5 0 0 skin.png\nnewmtl eye\nKd 1 0 0\n"
    mesh = read(tmp_path, SQUARE + UVS + TWO_FACES, library)
    assert mesh.uvs[mesh.render_triangles[0]].tolist() == [[0.5, 0], [2.5, 0], [2.5, 3]]
    assert mesh.uvs[mesh.render_triangles[1]].tolist() == [[0, 0], [1, 1], [0, 1]]


def test_one_grey_material_is_no_colour(tmp_path: Path) -> None:
    mesh = read(tmp_path, SQUARE + "usemtl a\nf 1 2 3 4\n", "newmtl a\nKd 0.8 0.8 0.8\n")
    assert mesh.materials == () and mesh.texture is None


# 10: names of objects


def test_an_object_is_a_group_and_a_group_overrides_it(tmp_path: Path) -> None:
    text = SQUARE + "o Hair_Mesh.001\nf 1 2 3\ng brow\nf 1 3 4\ng\nf 1 2 4\n"
    mesh = read(tmp_path, text)
    assert {name: rows.tolist() for name, rows in mesh.groups.items()} == {"Hair_Mesh.001": [0, 2], "brow": [1]}


# 11: texture references


@pytest.mark.parametrize(
    ("reference", "file"),
    [
        ("map_Kd -s 1 1 1 skin.png", "skin.png"),
        ("map_Kd -blendu on -o 0 0 -mm 0 1 -clamp off skin.png", "skin.png"),
        ("map_kd skin.png", "skin.png"),
        ("MAP_KD\tskin.png", "skin.png"),
        ("map_Kd SKIN.PNG", "skin.png"),
        (r"map_Kd C:\Users\me\skin.png", "skin.png"),
        (r"map_Kd .\maps\skin.png", "maps/skin.png"),
        ("map_Kd /home/me/work/skin.png", "skin.png"),
        ("map_Kd skin.png", "textures/skin.png"),
        ('map_Kd "skin.png"', "skin.png"),
        ("map_Kd my skin  2.png", "my skin  2.png"),
        ("map_Kd -s 1 1 1 my skin.png", "my skin.png"),
        ("map_Kd my%20skin.png", "my skin.png"),
        ("map_Kd skin.tga", "skin.png"),
    ],
)
def test_a_texture_is_found_as_people_name_it(tmp_path: Path, reference: str, file: str) -> None:
    png(tmp_path / file)
    mesh = read(tmp_path, SQUARE + UVS + "usemtl a\nf 1/1 2/2 3/3\n", f"newmtl a\n{reference}\n")
    assert mesh.texture == tmp_path / file and mesh.notes == ()


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
@pytest.mark.parametrize("file", [b"h\xc3\xa4ut.png", b"h\xe4ut.png"])
def test_a_texture_is_found_whatever_the_encoding_of_its_name(tmp_path: Path, encoding: str, file: bytes) -> None:
    path = tmp_path / os.fsdecode(file)
    path.write_bytes(png(tmp_path / "a.png").read_bytes())
    (tmp_path / "face.mtl").write_bytes("newmtl a\nmap_Kd häut.png\n".encode(encoding))
    mesh = read(tmp_path, f"mtllib face.mtl\n{SQUARE}{UVS}usemtl a\nf 1/1 2/2 3/3\n")
    assert (mesh.texture, mesh.notes) == (path, ())


@pytest.mark.parametrize(
    ("line", "file"),
    [
        (r"mtllib .\mtl\a.mtl", "mtl/a.mtl"),
        ("mtllib b.mtl a.mtl", "a.mtl"),
        ("mtllib b.mtl\nmtllib a.mtl", "a.mtl"),
        ("mtllib my face.mtl", "my face.mtl"),
        ("mtllib my#face.mtl", "my#face.mtl"),
        ("mtllib A.MTL", "a.mtl"),
        ("mtllib gone.mtl", "face.mtl"),
    ],
)
def test_a_library_is_found_as_people_name_it(tmp_path: Path, line: str, file: str) -> None:
    png(tmp_path / "skin.png")
    (tmp_path / "b.mtl").write_text("newmtl b\nKd 1 0 0\n")
    (tmp_path / file).parent.mkdir(exist_ok=True)
    (tmp_path / file).write_text("newmtl a\nmap_Kd skin.png\n")
    mesh = read(tmp_path, f"{line}\n{SQUARE}{UVS}usemtl a\nf 1/1 2/2 3/3\n")
    assert mesh.texture == tmp_path / "skin.png" and mesh.notes == ()


@pytest.mark.parametrize(
    ("text", "library", "note"),
    [
        ("", "newmtl a\nmap_Kd gone.png\n", "the image gone.png was not found: put it beside the mesh"),
        ("", "newmtl a\nmap_Kd skin.dds\n",
         "the image skin.dds cannot be read: convert it to PNG and name that in face.mtl"),
        ("mtllib gone.mtl\n", None, "the material library gone.mtl was not found beside the mesh"),
    ],
)  # fmt: skip
def test_a_missing_picture_is_named(tmp_path: Path, text: str, library: str | None, note: str) -> None:
    (tmp_path / "skin.dds").write_bytes(b"DDS ")
    mesh = read(tmp_path, text + SQUARE + UVS + "usemtl a\nf 1/1 2/2 3/3\n", library)
    assert mesh.notes == (note,)


# 12: byte-order marks and line breaks


def encodings(data: bytes) -> list[bytes]:
    text = data.decode()
    return [
        BOM + data,
        text.encode("utf-16"),
        b"\xfe\xff" + text.encode("utf-16-be"),
        data.replace(b"\n", b"\r\n"),
        data.replace(b"\r\n", b"\n").replace(b"\n", b"\r"),
    ]


@pytest.mark.parametrize("number", range(5))
def test_text_files_may_have_a_byte_order_mark_and_any_line_break(tmp_path: Path, number: int) -> None:
    motion = MotionClip(25.0, "fapu", np.zeros((2, CONTROL_POINT_COUNT, 3), np.float32))
    write_dpc(tmp_path / "a.dpc", motion)
    joy = DEFAULT_HEAD.parents[1] / "emotions" / "joy.epc"
    path = tmp_path / "encoded"
    path.write_bytes(encodings(DEFAULT_HEAD.with_suffix(".ppc").read_bytes())[number])
    assert np.array_equal(read_ppc(path), read_ppc(DEFAULT_HEAD.with_suffix(".ppc")))
    path.write_bytes(encodings((tmp_path / "a.dpc").read_bytes())[number])
    assert read_dpc(path).displacements.shape == motion.displacements.shape
    path.write_bytes(encodings(joy.read_bytes())[number])
    assert np.array_equal(read_epc(path).displacements, read_epc(joy).displacements)
    assert len(read(tmp_path, encodings((SQUARE + "f 1 2 3 4\n").encode())[number]).triangles) == 2


# 13: colours


@pytest.mark.parametrize("kind", ["obj", "ply", "glb"])
def test_vertex_colours_are_used(tmp_path: Path, kind: str) -> None:
    box = trimesh.creation.box()
    colours = np.tile([90, 60, 40, 255], (8, 1)).astype(np.uint8)
    colours[0] = 10, 20, 30, 255
    expected = colours[:, :3] / 255
    if kind == "obj":
        rows = "".join(
            f"v {x} {y} {z} {r} {g} {b}\n" for (x, y, z), (r, g, b) in zip(box.vertices, expected, strict=True)
        )
        mesh = read(tmp_path, rows + "".join(f"f {a} {b} {c}\n" for a, b, c in box.faces + 1))
    else:
        box.visual = trimesh.visual.ColorVisuals(box, vertex_colors=colours)
        box.export(tmp_path / f"face.{kind}")
        mesh = load_mesh(tmp_path / f"face.{kind}")
    assert mesh.vertex_colours == pytest.approx(expected, abs=0.005)
    assert material_of(mesh, 0).image is None


def test_a_texture_named_in_a_ply_is_used(tmp_path: Path) -> None:
    png(tmp_path / "skin.png", (90, 60, 40))
    header = "ply\nformat ascii 1.0\ncomment TextureFile C:\\scans\\Skin.png\nelement vertex 3\n"
    header += "".join(f"property float {name}\n" for name in "xyzst")
    header += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    mesh = read(tmp_path, header + "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n", name="face.ply")
    image = material_of(mesh, 0).image
    assert isinstance(image, np.ndarray) and image[0, 0].tolist() == [90, 60, 40, 255]
    assert mesh.uvs[mesh.render_triangles[0]].tolist() == [[0, 0], [1, 0], [0, 1]]


def test_vertex_colours_up_to_255_and_missing_ones(tmp_path: Path) -> None:
    mesh = read(tmp_path, "v 0 0 0\nv 1 0 0 51 102 255\nv 0 1 0\nf 1 2 3\n")
    assert mesh.vertex_colours is not None
    assert mesh.vertex_colours[1] == pytest.approx([0.2, 0.4, 1.0])


@pytest.mark.parametrize("kind", ["ply", "glb", "stl"])
def test_one_vertex_that_is_no_number_costs_its_triangles_only(tmp_path: Path, kind: str) -> None:
    ball = trimesh.creation.icosphere(subdivisions=2)
    ball.vertices[7] = np.nan
    (tmp_path / f"face.{kind}").write_bytes(ball.export(file_type=kind))
    mesh = load_mesh(tmp_path / f"face.{kind}")
    assert len(mesh.triangles) == np.count_nonzero((ball.faces != 7).all(axis=1))
    assert np.isfinite(mesh.vertices).all() and np.abs(mesh.vertices).max() < 1.01
    assert mesh.notes[0].endswith("triangles whose vertices are missing")


# 14: winding


@pytest.mark.parametrize("seed", range(3))
def test_mixed_winding_becomes_one(tmp_path: Path, seed: int) -> None:
    ball = trimesh.creation.icosphere(subdivisions=2)
    flip = np.random.default_rng(seed).random(len(ball.faces)) < 0.3
    faces = np.where(flip[:, None], ball.faces[:, ::-1], ball.faces) + 1
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in ball.vertices) + "".join(f"f {a} {b} {c}\n" for a, b, c in faces)
    mesh = read(tmp_path, text)
    corners = mesh.vertices[mesh.triangles]
    outwards = np.einsum("fi,fi->f", np.cross(*np.diff(corners, axis=1).transpose(1, 0, 2)), corners[:, 0])
    assert (outwards > 0).all()
    assert mesh.notes == (f"turned {flip.sum()} triangles that faced the wrong way",)


# 15: odd lines


@pytest.mark.parametrize(
    ("text", "note"),
    [
        ("f 1 2\n", "skipped 1 faces with fewer than three corners (first in line 13)"),
        ("vt nan 0\n", "skipped 1 texture coordinates that are no numbers (first in line 13)"),
        ("hello\nhello\n", "skipped 2 lines with an unknown keyword (first in line 13)"),
        ("f 1 2 99\n", "skipped 1 triangles whose vertices are missing"),
        ("f 1/9 2/9 3/9\n", "3 corners name texture coordinates that do not exist"),
        ("v 1 nan 2\nf 1 2 5\n", "skipped 1 vertices without three finite coordinates (first in line 13)"),
        ("v 1 2\n", "skipped 1 vertices without three finite coordinates (first in line 13)"),
        ("f 1 2 x\n", "skipped 1 faces that cannot be read (first in line 13)"),
        ("f 1 2 99999999999999999999999\n", "skipped 1 faces that cannot be read (first in line 13)"),
        ("\x1a", None),
        ("\x1a\x00\x00\n", None),
        ("v 5 5 5 1 1 1 1 1\n", None),
        ("f 1,0 2 3\n", "skipped 1 faces that cannot be read (first in line 13)"),
        ("v 1e400 0 0\nf 1 2 5\n", "skipped 1 vertices without three finite coordinates (first in line 13)"),
        ("v 1e30 0 0\nf 1 2 5\n", "skipped 1 triangles whose vertices are missing"),
        ("f 0 1 2\n", "skipped 1 triangles whose vertices are missing"),
        ("f -9 1 2\n", "skipped 1 triangles whose vertices are missing"),
        ("# " + "x" * 70_000 + "\nf 1 2 3\n", "skipped 1 lines of over 64 KB (first in line 13)"),
        ("f 1 1 2\nf 2 2 2\n", None),
        ("v 0 0 0\nv 1 1 0\n", None),
        (APART + "f\t5\t6\t7\n", None),
        (APART + "f 5 6 \\\n7\n", None),
        (APART + "f 5 6 \\ \n7\n", None),
        (APART + "F 5 6 7\nVN 0 0 1\n", None),
        (APART + "f -3 -2 -1\n", None),
        ("l 1 2 3\np 1\n", None),
    ],
)
def test_an_odd_line_is_skipped_and_named(tmp_path: Path, text: str, note: str | None) -> None:
    mesh = read(tmp_path, SQUARE + UVS + "g a\ng b\ng skin\nf 1/1 2/2 3/3 4/4\n" + text)
    assert mesh.notes[:1] == (() if note is None else (note,))
    assert mesh.triangles[:2].tolist() == [[0, 1, 2], [0, 2, 3]]
    assert mesh.vertices[:4].tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    assert np.isfinite(mesh.vertices).all() and np.isfinite(mesh.uvs).all()


def test_faces_before_their_vertices_and_decimal_commas_are_read(tmp_path: Path) -> None:
    mesh = read(tmp_path, "f 1 2 3\nv 0 0 0\nv 0,5 0 0\nv 0 1,5 0\n")
    assert mesh.vertices.tolist() == [[0, 0, 0], [0.5, 0, 0], [0, 1.5, 0]] and mesh.notes == ()


def test_a_concave_face_is_not_covered_from_outside(tmp_path: Path) -> None:
    mesh = read(tmp_path, "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nv 0 2 0\nf 1 2 3 4 5\n")
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    areas = np.cross(b - a, c - a)[:, 2] / 2
    assert (areas > 0).all() and areas.sum() == pytest.approx(2.5)


@pytest.mark.parametrize("text", ["f 1 1 1\n", "v 2 0 0\nf 1 2 5\n"])
def test_a_mesh_without_area_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(FileFormatError, match="expected a mesh, found only triangles without area: export it again"):
        read(tmp_path, SQUARE + text)


def test_a_mesh_of_too_many_vertices_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conf.face.formats.obj.MAX_VERTICES", 300)
    rows = "v 0 0 0\nv 1 0 0\nv 0 1 0\n" * 100
    assert len(read(tmp_path, rows + "f 1 2 300\n").vertices) == 300
    with pytest.raises(FileFormatError, match="expected at most 300 vertices"):
        read(tmp_path, rows + "v 0 0 0\n")


@pytest.mark.slow
def test_the_default_head_has_no_notes_and_one_texture() -> None:
    mesh = load_mesh(DEFAULT_HEAD)
    assert mesh.notes == () and mesh.materials == () and mesh.texture == DEFAULT_HEAD.with_name("skin.webp")


@pytest.mark.slow
def test_the_default_head_with_objects_instead_of_groups_has_the_same_parts(tmp_path: Path) -> None:
    lines = DEFAULT_HEAD.read_text().splitlines()
    text = "\n".join(f"o {line[2:]}_Mesh.001" if line.startswith("g ") else line for line in lines)
    for name in ("head.mtl", "skin.webp"):
        shutil.copy(DEFAULT_HEAD.with_name(name), tmp_path / name)
    mesh, head = read(tmp_path, text), load_mesh(DEFAULT_HEAD)
    assert [name.removesuffix("_Mesh.001") for name in mesh.groups] == list(head.groups)
