"""DPC files: the displacements of the control points, frame by frame.

The first line holds the number of frames. Each frame has one line `dx dy dz` per control point, relative to the neutral
pose. `#` starts a comment. The thesis's files hold nothing else, in the mesh's unit. Files written here add comments
that older readers skip: `# fps: 15`, `# units: fapu`, `# points: 50`, and before each frame `# pose: rx ry rz x y s`
(see head_pose.py). A line `...` is skipped, as in the thesis's printed sample.
Source: the thesis, section 5.2 (Dinâmicas dos Pontos de Controle).
"""

import io
from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from conf.atomic_write import atomic_write
from conf.errors import FileFormatError
from conf.face.formats.text import parse_floats, read_lines

DEFAULT_FPS = 15.0
MAX_FRAMES = 1_000_000
MAX_DISPLACEMENT = 1e6  # FAPU units; an open jaw has about 1,500
_POSE_NUMBERS = 6
_COUNT_WIDTH = len(str(MAX_FRAMES))  # characters that a file written in parts keeps for its number of frames
_Number = TypeVar("_Number", int, float)
_FRAME_COUNT = "expected the number of frames"
_ROW = "expected `dx dy dz`, the displacement of one control point"


@dataclass(frozen=True)
class MotionClip:
    """A recorded motion.

    fps : frames per second
    units : "fapu" (1/1024 of the governing distance) or "mesh" (the length unit of the face it was made for)
    displacements : (N, n, 3) float32, from the neutral pose, head pose removed
    poses : (N, 6) float64 head poses, or None if the file has none
    """

    fps: float
    units: str
    displacements: NDArray[np.float32]
    poses: NDArray[np.float64] | None = None


def read_dpc(path: Path | str, /) -> MotionClip:
    """Read a DPC file, with or without the comment header.

    Raises FileFormatError if the file is not the number of frames and as many lines for each frame.
    """
    return _DpcText(Path(path)).read()


def write_dpc(path: Path | str, motion: MotionClip, /) -> None:
    """Write a motion, displacements with two decimals, with fps, units and poses in comments.

    Raises ValueError if the motion has no frames, or the number of poses differs.
    """
    frames, points, _ = motion.displacements.shape
    if frames == 0 or not np.isfinite(motion.displacements).all():
        raise ValueError("motion must have at least one frame, and finite displacements")
    if motion.poses is not None and motion.poses.shape != (frames, _POSE_NUMBERS):
        raise ValueError(f"poses must have shape {(frames, _POSE_NUMBERS)}, got {motion.poses.shape}")
    with atomic_write(path) as partial, partial.open("w", encoding="utf-8") as file:
        file.writelines(f"{line}\n" for line in _lines(motion, frames, points))


class DpcWriter:
    """Writes a DPC file of FAPU displacements with poses in parts; after each of them the file is whole.

    path : of the file; it may be renamed between two parts
    frames : written so far
    """

    def __init__(self, path: Path, *, fps: float) -> None:
        """The first `write` creates the file."""
        self.path = path
        self.frames = 0
        self._fps = fps
        self._end = 0  # of what is whole, bytes

    def write(self, displacements: NDArray[np.float32], poses: NDArray[np.float64]) -> None:
        """Append frames, (k, n, 3) and (k, 6). Raises OSError; the file then ends before them."""
        with self.path.open("r+b" if self.frames else "wb") as file:
            try:
                if not self.frames:
                    header = _header(f"{0:<{_COUNT_WIDTH}}", self._fps, "fapu", displacements.shape[1])
                    file.writelines(f"{line}\n".encode() for line in header)
                file.seek(0, io.SEEK_END)
                file.writelines(f"{line}\n".encode() for line in _rows(displacements, poses, self.frames))
                file.flush()
            except OSError:
                file.truncate(self._end)
                raise
            self._end = file.tell()
            self.frames += len(displacements)
            file.seek(0)
            file.write(f"{self.frames:<{_COUNT_WIDTH}}".encode())


def _lines(motion: MotionClip, frames: int, points: int) -> Iterator[str]:
    yield from _header(str(frames), motion.fps, motion.units, points)
    yield from _rows(motion.displacements, motion.poses, 0)


def _header(frames: str, fps: float, units: str, points: int) -> Iterator[str]:
    yield f"{frames}  # frames"
    yield f"# fps: {fps:.6g}"
    yield f"# units: {units}"
    yield f"# points: {points}"


def _rows(displacements: NDArray[np.float32], poses: NDArray[np.float64] | None, first: int) -> Iterator[str]:
    """Yield the lines of frames, of which the first has a number."""
    for i, frame in enumerate(displacements):
        yield f"# frame {first + i}"
        if poses is not None:
            yield "# pose: " + " ".join(f"{value:.6f}" for value in poses[i])
        yield from (f"{dx:.2f} {dy:.2f} {dz:.2f}" for dx, dy, dz in frame.tolist())


class _DpcText:
    """Parser state of one DPC file."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._fps, self._units, self._points = DEFAULT_FPS, "mesh", 0
        self._frames = 0
        self._numbers = array("f")
        self._poses = array("d")

    def read(self) -> MotionClip:
        number = 0
        for number, line in read_lines(self._path):
            data, _, comment = line.partition(b"#")
            words = data.split()
            if comment:
                self._read_comment(comment, number)
            if words and words != [b"..."]:
                self._read_row(words, number)
        return self._result(number)

    def _read_row(self, words: list[bytes], number: int) -> None:
        if not self._frames:
            self._frames = self._positive(words, number, f"{_FRAME_COUNT}, 1 to {MAX_FRAMES}", MAX_FRAMES)
            return
        if len(words) != 3:
            raise FileFormatError(self._path, number, _ROW)
        values = parse_floats(words, self._path, number, _ROW)
        if max(map(abs, values)) > MAX_DISPLACEMENT:
            raise FileFormatError(self._path, number, f"expected displacements of at most {MAX_DISPLACEMENT:g}")
        self._numbers.extend(values)

    def _read_comment(self, comment: bytes, number: int) -> None:
        key, colon, value = comment.partition(b":")
        reader = _HEADER.get(key.strip()) if colon else None
        if reader:
            reader(self, value.split(), number)

    def _read_fps(self, words: list[bytes], number: int) -> None:
        self._fps = self._positive(words, number, "expected `# fps: N`, N above 0 and at most 1000", 1000.0)

    def _read_units(self, words: list[bytes], number: int) -> None:
        if words not in ([b"fapu"], [b"mesh"]):
            raise FileFormatError(self._path, number, "expected `# units: fapu` or `# units: mesh`")
        self._units = words[0].decode("ascii")

    def _read_points(self, words: list[bytes], number: int) -> None:
        self._points = self._positive(words, number, "expected `# points: N`, 1 to 10000", 10_000)

    def _read_pose(self, words: list[bytes], number: int) -> None:
        expected = "expected `# pose: rx ry rz x y s`"
        if len(words) != _POSE_NUMBERS:
            raise FileFormatError(self._path, number, expected)
        self._poses.extend(parse_floats(words, self._path, number, expected))

    def _positive(self, words: list[bytes], number: int, expected: str, max_value: _Number) -> _Number:
        """Return the words as a positive number of the type of max_value, at most max_value."""
        try:
            value = type(max_value)(b" ".join(words))
        except ValueError as error:
            raise FileFormatError(self._path, number, expected) from error
        if not 0 < value <= max_value:
            raise FileFormatError(self._path, number, expected)
        return value

    def _result(self, number: int) -> MotionClip:
        rows = len(self._numbers) // 3
        if not self._frames:
            raise FileFormatError(self._path, None, f"{_FRAME_COUNT} on the first line")
        points = self._points or rows // self._frames
        if not rows or rows != self._frames * points:
            expected = f"{self._frames} frames of {points} points" if self._points else "as many lines for each frame"
            raise FileFormatError(self._path, number, f"expected {expected}, found {rows} lines of displacements")
        poses = np.array(self._poses).reshape(-1, _POSE_NUMBERS)
        if len(poses) not in (0, self._frames):
            raise FileFormatError(self._path, number, f"expected a pose for each of {self._frames} frames or for none")
        displacements = np.array(self._numbers, dtype=np.float32).reshape(self._frames, points, 3)
        return MotionClip(self._fps, self._units, displacements, poses if len(poses) else None)


_HEADER = {
    b"fps": _DpcText._read_fps,
    b"units": _DpcText._read_units,
    b"points": _DpcText._read_points,
    b"pose": _DpcText._read_pose,
}
