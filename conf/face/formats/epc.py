"""EPC files: named expressions of a face, one DPC frame each.

An EPC file is a DPC file (see dpc.py) with a comment such as `# name: joy` before the first line of each frame, so
every DPC reader reads it. Frames without a name, as in the thesis's files, are named after the file: `joy` for the
frame of `joy.epc`, or `joy 1`, `joy 2` for several.
Source: the thesis, section 5.1 (Emoções em Pontos de Controle: "no mesmo padrão dos DPC's").
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.atomic_write import atomic_write
from conf.errors import FileFormatError
from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINTS
from conf.face.fapu import Fapu
from conf.face.formats.dpc import read_dpc
from conf.face.formats.text import check_file, read_lines

MAX_FILE_BYTES = 8 << 20  # about five thousand expressions
MAX_NAME = 60  # characters


@dataclass(frozen=True)
class ExpressionSet:
    """Named expressions.

    names : N distinct names
    displacements : (N, n, 3) float32, from the neutral pose
    units : "fapu" (1/1024 of the governing distance) or "mesh" (the length unit of the face they were made for)
    """

    names: tuple[str, ...]
    displacements: NDArray[np.float32]
    units: str = "fapu"

    def __getitem__(self, name: str) -> NDArray[np.float32]:
        """Return the (n, 3) displacements of one expression. Raises KeyError for an unknown name."""
        if name not in self.names:
            raise KeyError(name)
        frame: NDArray[np.float32] = self.displacements[self.names.index(name)]
        return frame

    def in_fapu(self, fapu: Fapu, /) -> "ExpressionSet":
        """Return the expressions in FAPU units. fapu : of the face they were made for, in its length unit."""
        if self.units == "fapu":
            return self
        return replace(self, displacements=(self.displacements / fapu.lengths()).astype(np.float32), units="fapu")

    def __len__(self) -> int:
        return len(self.names)


def read_epc(path: Path | str, /) -> ExpressionSet:
    """Read named expressions of the fifty control points.

    Raises FileFormatError if the file does not hold them, whatever its bytes.
    """
    path = Path(path)
    check_file(path, max_bytes=MAX_FILE_BYTES)
    motion = read_dpc(path)
    frames, points, _ = motion.displacements.shape
    if points != CONTROL_POINT_COUNT:
        raise FileFormatError(path, None, f"expected {CONTROL_POINT_COUNT} control points a frame, found {points}")
    names_by_frame = _read_names(path)
    default = path.stem[:MAX_NAME] or "expression"
    numbered = (default,) if frames == 1 else tuple(f"{default} {i + 1}" for i in range(frames))
    names = tuple(names_by_frame.get(i, numbered[i]) for i in range(frames))
    if len(set(names)) != frames:
        raise FileFormatError(path, None, "expected a different name for each frame")
    return ExpressionSet(names, motion.displacements, motion.units)


def write_epc(path: Path | str, expressions: ExpressionSet, /, *, comments: Sequence[str] = ()) -> None:
    """Write named expressions, displacements with one decimal, each line with the name of its control point.

    comments : comment lines at the top of the file
    Raises ValueError if a name or a displacement could not be read back.
    """
    shape = (len(expressions), CONTROL_POINT_COUNT, 3)
    if len(expressions) == 0 or expressions.displacements.shape != shape:
        raise ValueError(f"displacements must have shape {shape}, got {expressions.displacements.shape}")
    if not np.isfinite(expressions.displacements).all():
        raise ValueError("displacements must be finite")
    if any(not is_name(name) for name in expressions.names) or len(set(expressions.names)) != len(expressions):
        raise ValueError(f"names must be different lines of 1 to {MAX_NAME} characters, got {expressions.names}")
    lines = [f"{len(expressions)}  # frames", f"# units: {expressions.units}", f"# points: {CONTROL_POINT_COUNT}"]
    lines += [f"# {comment}" for comment in comments]
    for name, frame in zip(expressions.names, expressions.displacements.tolist(), strict=True):
        lines += ["", f"# name: {name}"]
        lines += [
            f"{dx:.1f} {dy:.1f} {dz:.1f}  # {point.index} {point.name}"
            for point, (dx, dy, dz) in zip(CONTROL_POINTS, frame, strict=True)
        ]
    with atomic_write(path) as partial:
        partial.write_text("\n".join(lines) + "\n", encoding="utf-8")


def is_name(name: str, /) -> bool:
    """Tell whether a name can be written to a file and read back."""
    return 0 < len(name) <= MAX_NAME and name.isprintable() and name == name.strip() and "#" not in name


def _read_names(path: Path) -> dict[int, str]:
    """Return the names by frame of a file that read_dpc has accepted."""
    names: dict[int, str] = {}
    rows = -1  # the first line of data holds the number of frames
    for number, line in read_lines(path):
        data, _, comment = line.partition(b"#")
        rows += bool(data.split()) and data.split() != [b"..."]
        key, colon, value = comment.partition(b":")
        if not colon or key.strip() != b"name":
            continue
        frame, row = divmod(max(rows, 0), CONTROL_POINT_COUNT)
        if row or frame in names:
            raise FileFormatError(path, number, "expected `# name:` once, before the first line of the frame it names")
        names[frame] = value.decode("utf-8", "surrogateescape").strip()  # surrogates are not printable
        if not is_name(names[frame]):
            raise FileFormatError(path, number, f"expected `# name:` and up to {MAX_NAME} printable characters")
    return names
