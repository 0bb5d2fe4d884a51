from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.face.formats.mtl import MeshMaterial, find_file, read_material_libraries


def read(folder: Path, text: str | bytes) -> tuple[dict[str, MeshMaterial], list[str]]:
    (folder / "face.mtl").write_bytes(text.encode() if isinstance(text, str) else text)
    notes: list[str] = []
    return read_material_libraries(folder / "face.obj", ["face.mtl"], notes), notes


@pytest.mark.parametrize(
    ("line", "colour", "alpha"),
    [
        ("Kd 0.1 0.2 0.3", (0.1, 0.2, 0.3), 1.0),
        ("kd 0,5 0,5 0,25", (0.5, 0.5, 0.25), 1.0),
        ("Kd 0.5", (0.5, 0.5, 0.5), 1.0),
        ("Kd 7 -1 nan", (1.0, 1.0, 1.0), 1.0),
        ("Kd spectral file.rfl", (1.0, 1.0, 1.0), 1.0),
        ("d 0.25", (1.0, 1.0, 1.0), 0.25),
        ("d -halo 0.25", (1.0, 1.0, 1.0), 0.25),
        ("Tr 0.25", (1.0, 1.0, 1.0), 0.75),
        ("Tr 1.0", (1.0, 1.0, 1.0), 1.0),
        ("d 0.5\nTr 0.5", (1.0, 1.0, 1.0), 0.5),
    ],
)
def test_colour_and_alpha(tmp_path: Path, line: str, colour: tuple[float, ...], alpha: float) -> None:
    materials, _ = read(tmp_path, f"newmtl a\n{line}\n")
    if line == "Kd 7 -1 nan":  # two numbers are read: one is the brightness
        assert materials["a"].colour == (1.0, 1.0, 1.0)
    assert materials["a"].colour == colour and materials["a"].alpha == alpha


def test_files_are_looked_for_in_the_folder_of_the_library_first(tmp_path: Path) -> None:
    for folder in (tmp_path, tmp_path / "mtl"):
        folder.mkdir(exist_ok=True)
        (folder / "skin.png").touch()
    (tmp_path / "mtl" / "a.mtl").write_text("newmtl a\nmap_Kd skin.png\n")
    found = read_material_libraries(tmp_path / "face.obj", ["mtl/a.mtl"], [])
    assert found["a"].image == tmp_path / "mtl" / "skin.png"


@pytest.mark.parametrize("name", ["", "\0", "..", "x" * 5000, "a/../../b", "\\\\host\\share\\skin.png"])
def test_a_name_of_no_file_finds_none(tmp_path: Path, name: str) -> None:
    assert find_file(name, [tmp_path]) is None


@pytest.mark.slow
@given(st.binary(max_size=200))
def test_any_bytes_are_read(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    materials, _ = read(tmp_path_factory.getbasetemp(), b"newmtl a\n" + data)
    for material in materials.values():
        assert 0 <= material.alpha <= 1 and all(0 <= value <= 1 for value in material.colour)
