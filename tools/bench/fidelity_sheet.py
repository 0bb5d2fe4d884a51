"""Draw a sheet of the moments in which a drawn head differs most from the person: source above, drawing below.

    python tools/bench/fidelity_sheet.py CLIP SHEET.png [--count 8] [--size 640] [--face FACE.obj]

The clip is drawn as tools/bench/fidelity.py draws it. A moment's error is that of its worst curve of
tools/bench/expression_curves.py on the vertices that are drawn, medians over the clip removed, in eye distances. Each
drawing is labelled with its time, that curve, and the error in percent of the eye distance.
"""

import argparse
import os
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cv2
import numpy as np
from numpy.typing import NDArray

from tools.bench.expression_curves import REPORTED, reported_curves
from tools.bench.fidelity import Pair, run
from tools.bench.fidelity_tracks import landmark_points, relative_pupils

COUNT, SIZE, COLUMNS = 8, 640, 4
SPACING_S = 0.4  # between two moments
_FACE_SHARE = 0.62  # of the cell's height, from brows to chin, as the drawn head fills it
_RISE = 0.1  # of the cell's height, by which the middle of the landmarks is drawn below the cell's
_LABEL, _LABEL_SCALE = (16, 36), 0.9


def main() -> None:
    """Write the sheet."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("clip", type=Path)
    parser.add_argument("sheet", type=Path)
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--size", type=int, default=SIZE, help="width and height of each face, px")
    parser.add_argument("--face", type=Path, help="mesh of another face, with its PPC in the same folder")
    options = parser.parse_args()
    pairs = list(run(options.clip, options.face, size=(options.size, options.size)))
    if not pairs:
        sys.exit(f"{options.clip}: no face was found")
    errors = expression_errors(
        landmark_points(np.stack([pair.aligned for pair in pairs]), bridge=True),
        relative_pupils(np.stack([pair.vertices for pair in pairs])),
    )
    chosen = worst_moments(errors.max(axis=1), np.array([pair.timestamp for pair in pairs]), options.count)
    cv2.imwrite(str(options.sheet), draw_sheet([(pairs[i], errors[i]) for i in chosen], options.size))


def expression_errors(source: NDArray[np.float64], drawn: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return the (N, R) errors of the curves of REPORTED, eye distances, medians over the frames removed.

    source, drawn : (N, n, 3) as `reported_curves` asks
    """
    a, b = (curves - np.median(curves, axis=0) for curves in (reported_curves(source), reported_curves(drawn)))
    return np.abs(b - a)


def worst_moments(
    errors: NDArray[np.float64], times: NDArray[np.float64], count: int, /, *, spacing: float = SPACING_S
) -> list[int]:
    """Return the frames with the greatest errors, in order of time, at most `count`, `spacing` seconds apart.

    errors : (N,); times : (N,) seconds
    """
    chosen: list[int] = []
    for frame in np.argsort(-errors, kind="stable").tolist():
        if len(chosen) < count and all(abs(times[frame] - times[other]) >= spacing for other in chosen):
            chosen.append(frame)
    return sorted(chosen)


def draw_sheet(moments: list[tuple[Pair, NDArray[np.float64]]], size: int, /) -> NDArray[np.uint8]:
    """Return the moments, BGR, in rows of COLUMNS. moments : each with its errors (R,); size : of each face, px"""
    cells = [np.vstack([crop_face(pair, size), labelled(pair, errors)]) for pair, errors in moments]
    columns = min(COLUMNS, len(cells))
    cells += [np.zeros_like(cells[0])] * (-len(cells) % columns)
    rows = [np.hstack(cells[start : start + columns]) for start in range(0, len(cells), columns)]
    return np.asarray(np.vstack(rows), np.uint8)


def labelled(pair: Pair, errors: NDArray[np.float64], /) -> NDArray[np.uint8]:
    """Return a drawing with its time, its worst curve and the error."""
    image = pair.drawing.copy()
    worst = int(errors.argmax())
    text = f"{pair.timestamp:.2f} s: {list(REPORTED)[worst]} {100 * errors[worst]:.1f} %"
    cv2.putText(image, text, _LABEL, cv2.FONT_HERSHEY_SIMPLEX, _LABEL_SCALE, (0, 255, 255), 2, cv2.LINE_AA)
    return image


def crop_face(pair: Pair, size: int, /) -> NDArray[np.uint8]:
    """Return the part of the person's image around the face, (size, size, 3), the face as large as the drawn one."""
    low, high = pair.landmarks[:, :2].min(axis=0), pair.landmarks[:, :2].max(axis=0)
    side = float(high[1] - low[1]) / _FACE_SHARE
    corner = (low + high) / 2 - (side / 2, side * (0.5 + _RISE))
    transform = np.array([[size / side, 0, -corner[0] * size / side], [0, size / side, -corner[1] * size / side]])
    return np.asarray(cv2.warpAffine(pair.pixels, transform, (size, size), flags=cv2.INTER_CUBIC), np.uint8)


if __name__ == "__main__":
    main()
