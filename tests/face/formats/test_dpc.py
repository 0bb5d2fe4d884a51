from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from conf.errors import FileFormatError
from conf.face.formats.dpc import DpcWriter, MotionClip, read_dpc, write_dpc

# The sample of the thesis, section 5.2, as printed.
THESIS = """
2                # Total de quadros

1.0  2.0  0.0   #
1.1  0.0  0.5   # Primeiro Quadro
...                #
0.0 -3.0  3.0   #

2.0  2.0  0.0   #
0.0 -1.0  3.0   # Segundo Quadro
...                #
0.0 -3.0  3.0   #
"""

GOLDEN = """2  # frames
# fps: 12.5
# units: fapu
# points: 1
# frame 0
# pose: 0.100000 0.200000 0.300000 0.400000 0.500000 0.600000
1.00 -2.50 0.00
# frame 1
# pose: 0.000000 0.000000 0.000000 0.000000 0.000000 0.000000
0.00 0.00 1000.00
"""
MOTION = MotionClip(
    fps=12.5,
    units="fapu",
    displacements=np.array([[[1, -2.5, 0]], [[0, 0, 1000]]], dtype=np.float32),
    poses=np.array([[0.1, 0.2, 0.3, 0.4, 0.5, 0.6], [0] * 6]),
)


def read(tmp_path: Path, text: str) -> MotionClip:
    path = tmp_path / "motion.dpc"
    path.write_text(text)
    return read_dpc(path)


def test_the_thesis_sample_is_read(tmp_path: Path) -> None:
    motion = read(tmp_path, THESIS)
    assert motion.units == "mesh"
    assert motion.poses is None
    assert motion.displacements.shape == (2, 3, 3)
    assert motion.displacements[1].tolist() == [[2, 2, 0], [0, -1, 3], [0, -3, 3]]


def test_the_golden_file_is_written_and_read(tmp_path: Path) -> None:
    write_dpc(tmp_path / "written.dpc", MOTION)
    assert (tmp_path / "written.dpc").read_text() == GOLDEN
    motion = read(tmp_path, GOLDEN)
    assert (motion.fps, motion.units) == (12.5, "fapu")
    assert motion.displacements.tolist() == MOTION.displacements.tolist()
    assert motion.poses == pytest.approx(MOTION.poses)


@pytest.mark.slow
@given(arrays(np.float32, (3, 50, 3), elements=st.floats(-4000, 4000, width=32)), st.floats(1, 120))
def test_motions_are_read_back(tmp_path_factory: pytest.TempPathFactory, displacements: np.ndarray, fps: float) -> None:
    path = tmp_path_factory.getbasetemp() / "round.dpc"
    write_dpc(path, MotionClip(fps, "fapu", displacements))
    motion = read_dpc(path)
    assert motion.displacements == pytest.approx(displacements, abs=0.006)
    assert motion.fps == pytest.approx(fps, rel=1e-5)


@pytest.mark.parametrize(
    ("text", "line", "expected"),
    [
        ("", None, "expected the number of frames on the first line"),
        ("# only comments\n", None, "expected the number of frames on the first line"),
        ("two\n1 2 3\n", 1, "expected the number of frames"),
        ("0\n", 1, "expected the number of frames, 1 to 1000000"),
        ("1000001\n", 1, "expected the number of frames, 1 to 1000000"),
        ("1 2 3\n", 1, "expected the number of frames"),
        ("1\n", 1, "found 0 lines of displacements"),
        ("2\n1 2 3\n", 2, "expected as many lines for each frame, found 1"),
        ("1\n# points: 2\n1 2 3\n", 3, "expected 1 frames of 2 points, found 1"),
        ("1\n1 2\n", 2, "expected `dx dy dz`"),
        ("1\n1 2 nan\n", 2, "each finite"),
        ("1\n1 2 2e6\n", 2, "expected displacements of at most 1e+06"),
        ("1\n# fps: 0\n1 2 3\n", 2, "expected `# fps: N`"),
        ("1\n# fps: fast\n1 2 3\n", 2, "expected `# fps: N`"),
        ("1\n# units: inches\n1 2 3\n", 2, "expected `# units: fapu`"),
        ("1\n# points: x\n1 2 3\n", 2, "expected `# points: N`"),
        ("1\n# pose: 1 2 3\n1 2 3\n", 2, "expected `# pose: rx ry rz x y s`"),
        ("2\n# pose: 1 2 3 4 5 6\n1 2 3\n1 2 3\n", 4, "expected a pose for each of 2 frames or for none"),
    ],
)
def test_errors_name_the_line(tmp_path: Path, text: str, line: int | None, expected: str) -> None:
    with pytest.raises(FileFormatError) as caught:
        read(tmp_path, text)
    assert caught.value.line == line
    assert expected in str(caught.value)


def test_other_comments_are_ignored(tmp_path: Path) -> None:
    assert read(tmp_path, "1 # fps unknown\n1 2 3 # pose of the man\n").fps == 15.0


WORDS = st.sampled_from(
    ["1", "2", "-3.5", "1e7", "...", "#", "# fps: 5\n", "# units: fapu\n", "# points: 1\n", "# pose:", "\n", "x"]
)


@pytest.mark.slow
@given(st.one_of(st.binary(max_size=300), st.lists(WORDS, max_size=60).map(lambda words: " ".join(words).encode())))
def test_any_bytes_give_a_motion_or_file_format_error(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "any.dpc"
    path.write_bytes(data)
    try:
        motion = read_dpc(path)
    except FileFormatError:
        return
    frames, points, axes = motion.displacements.shape
    assert frames >= 1 and points >= 1 and axes == 3
    assert np.isfinite(motion.displacements).all()


def test_incomplete_motions_are_not_written(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="at least one frame"):
        write_dpc(tmp_path / "x", replace(MOTION, displacements=np.zeros((0, 1, 3), np.float32)))
    with pytest.raises(ValueError, match=r"poses must have shape \(2, 6\)"):
        write_dpc(tmp_path / "x", replace(MOTION, poses=np.zeros((1, 6))))


def test_a_file_written_in_parts_is_whole_after_each_of_them(tmp_path: Path) -> None:
    rng, writer = np.random.default_rng(2), DpcWriter(tmp_path / "motion.dpc", fps=15)
    displacements = rng.integers(-100, 100, (12, 50, 3)).astype(np.float32)
    poses = rng.integers(-100, 100, (12, 6)) / 64
    for start, end in ((0, 1), (1, 5), (5, 12)):
        writer.write(displacements[start:end], poses[start:end])
        motion = read_dpc(tmp_path / "motion.dpc")
        assert writer.frames == end and motion.fps == 15 and motion.units == "fapu" and motion.poses is not None
        np.testing.assert_array_equal(motion.displacements, displacements[:end])
        np.testing.assert_array_equal(motion.poses, poses[:end])
    write_dpc(tmp_path / "whole.dpc", MotionClip(15, "fapu", displacements, poses))
    in_parts, whole = ((tmp_path / name).read_text().splitlines() for name in ("motion.dpc", "whole.dpc"))
    assert in_parts[1:] == whole[1:] and in_parts[0].split() == whole[0].split()


def test_a_part_that_cannot_be_written_leaves_the_file_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    writer = DpcWriter(tmp_path / "motion.dpc", fps=15)
    displacements, poses = np.ones((2, 50, 3), np.float32), np.zeros((2, 6))
    writer.write(displacements, poses)
    before = (tmp_path / "motion.dpc").read_bytes()

    def full_disk(*args: object) -> Iterator[str]:
        yield "# frame 2"
        yield "x" * 100_000
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch, pytest.raises(OSError, match="No space left"):
        patch.setattr("conf.face.formats.dpc._rows", full_disk)
        writer.write(displacements, poses)
    assert (tmp_path / "motion.dpc").read_bytes() == before
    writer.write(displacements, poses)
    assert len(read_dpc(tmp_path / "motion.dpc").displacements) == 4
