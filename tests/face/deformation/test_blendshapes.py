from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import FileFormatError
from conf.face.deformation.blendshapes import Blendshapes, load_blendshapes

OFFSETS = np.arange(24, dtype=np.float16).reshape(2, 4, 3)


def test_names_and_offsets_are_read(tmp_path: Path) -> None:
    np.savez_compressed(tmp_path / "shapes.npz", names=np.array(["smile", "blink"]), offsets=OFFSETS)
    shapes = load_blendshapes(tmp_path / "shapes.npz", 4)
    assert shapes.names == ("smile", "blink")
    assert shapes.offsets.dtype == np.float32
    assert shapes.offsets.tolist() == OFFSETS.tolist()


def test_a_single_name_needs_no_list(tmp_path: Path) -> None:
    np.savez(tmp_path / "shapes.npz", names=np.array("smile"), offsets=OFFSETS[:1])
    assert load_blendshapes(tmp_path / "shapes.npz", 4).names == ("smile",)


@pytest.mark.parametrize(
    "arrays",
    [
        {"names": np.array(["a", "b"]), "offsets": OFFSETS[:, :3]},
        {"names": np.array(["a"]), "offsets": OFFSETS},
        {"names": np.array(["a", "b"]), "offsets": np.full((2, 4, 3), np.nan)},
        {"names": np.array(["a", "b"]), "offsets": np.full((2, 4, 3), "x")},
        {"names": np.array(["a", "b"]), "offsets": np.full((2, 4, 3), {}, dtype=object)},
        {"names": np.array(["a", "b"])},
    ],
)
def test_other_arrays_raise_file_format_error(tmp_path: Path, arrays: dict[str, Any]) -> None:
    np.savez(tmp_path / "shapes.npz", **arrays)
    with pytest.raises(FileFormatError, match=r"shapes\.npz: expected"):
        load_blendshapes(tmp_path / "shapes.npz", 4)


@pytest.mark.slow
@given(st.data())
def test_damaged_files_give_blendshapes_or_file_format_error(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    path = tmp_path_factory.getbasetemp() / "damaged.npz"
    np.savez_compressed(path, names=np.array(["smile", "blink"]), offsets=OFFSETS)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(0, 5))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content[: data.draw(st.integers(0, len(content)))])
    try:
        assert isinstance(load_blendshapes(path, 4), Blendshapes)
    except FileFormatError:
        pass
