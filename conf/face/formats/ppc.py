"""PPC files: the positions of the control points on one face.

One line `x y z` per control point, in the order of control_points.py, in the face's length unit; `#` starts a comment.
Source: the thesis, section 5.2 (Posições dos Pontos de Controle).
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.atomic_write import atomic_write
from conf.errors import FileFormatError
from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINTS
from conf.face.formats.text import parse_floats, read_lines

_LINE = "expected `x y z`, the position of one control point"


def read_ppc(path: Path | str, /) -> NDArray[np.float64]:
    """Return the (n, 3) positions of the control points, in the face's length unit.

    Raises FileFormatError if the file does not have one line of three numbers for each control point.
    """
    path = Path(path)
    rows: list[list[float]] = []
    for number, line in read_lines(path):
        words = line.split(b"#", 1)[0].split()
        if not words:
            continue
        if len(words) != 3 or len(rows) == CONTROL_POINT_COUNT:
            message = _LINE if len(words) != 3 else f"expected the file to end after {CONTROL_POINT_COUNT} points"
            raise FileFormatError(path, number, message)
        rows.append(parse_floats(words, path, number, _LINE))
    if len(rows) != CONTROL_POINT_COUNT:
        raise FileFormatError(path, None, f"expected {CONTROL_POINT_COUNT} control points, found {len(rows)}")
    return np.array(rows)


def write_ppc(path: Path | str, points: NDArray[np.floating], /) -> None:
    """Write the (n, 3) positions of the control points, each with its number and name as a comment."""
    if points.shape != (CONTROL_POINT_COUNT, 3) or not np.isfinite(points).all():
        raise ValueError(f"points must be {CONTROL_POINT_COUNT} finite positions, got shape {points.shape}")
    lines = ["# positions of the control points: x y z"]
    for point, (x, y, z) in zip(CONTROL_POINTS, points, strict=True):
        lines.append(f"{x:.6f} {y:.6f} {z:.6f}  # {point.index} {point.feature_point} {point.name}")
    with atomic_write(path) as partial:
        partial.write_text("\n".join(lines) + "\n", encoding="utf-8")
