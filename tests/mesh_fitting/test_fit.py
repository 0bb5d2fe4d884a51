"""Fit the default head, exported in another format, unit and orientation."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from conf.errors import ConfError, FileFormatError
from conf.face.control_points import CONTROL_POINT_INDEX, CONTROL_POINT_LANDMARKS, PUPILS
from conf.face.default_head import DEFAULT_HEAD
from conf.face.formats.ppc import read_ppc
from conf.face.mesh.axes import axes_rotation
from conf.face.mesh.mesh import Mesh, load_mesh
from conf.mesh_fitting.face_search import READ
from conf.mesh_fitting.fit import TRACKER_MESH_NOTE, fit, points_of_landmark_mesh
from conf.sender.tracking.canonical_face import CanonicalFace, load_canonical_face

pytestmark = pytest.mark.usefixtures("gl", "models")


@pytest.fixture
def canonical() -> CanonicalFace:
    return load_canonical_face()


def errors_mm(found: NDArray[np.float64], truth: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.linalg.norm(found - truth, axis=1) * 64 / np.linalg.norm(np.subtract(*truth[PUPILS])))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("suffix", "unit", "axes", "up"), [(".ply", 0.01, ("-y", "z"), "-y"), (".stl", 10.0, ("z", "x"), None)]
)
def test_the_default_head_without_its_points_is_fitted(
    tmp_path: Path, suffix: str, unit: float, axes: tuple[str, str], up: str | None
) -> None:
    mesh, truth = load_mesh(DEFAULT_HEAD), read_ppc(DEFAULT_HEAD.with_suffix(".ppc"))
    triangles = np.concatenate([mesh.triangles[mesh.groups[name]] for name in ("skin", "mouth", "eye_l", "eye_r")])
    rotation = axes_rotation(*axes) * unit
    path, output = tmp_path / f"head{suffix}", tmp_path / "head.ppc"
    trimesh.Trimesh(mesh.vertices @ rotation, triangles, process=False).export(path)
    steps: list[tuple[float, str]] = []
    report = fit(path, output, up=up, on_progress=lambda fraction, text: steps.append((fraction, text)))
    assert (report.up, report.front) == axes
    assert report.mouth_open and report.lip_lines == 3
    assert report.eye_distance == pytest.approx(6.4 * unit, rel=0.03)
    errors = errors_mm(read_ppc(output), truth @ rotation)
    assert errors.mean() < 2.0
    assert errors.max() < 6.0
    fractions, texts = zip(*steps, strict=True)
    assert fractions[0] == READ and 0.9 < fractions[-1] < 1.0 and list(fractions) == sorted(fractions)
    assert texts[1].startswith("looking for the face") and "tracking the face from side 12 of 12" in texts


@pytest.mark.slow
def test_a_mesh_of_landmarks_needs_no_tracking(tmp_path: Path, canonical: CanonicalFace) -> None:
    path, output = tmp_path / "mask.obj", tmp_path / "mask.ppc"
    lines = [f"v {x} {y} {z}" for x, y, z in canonical.vertices]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in canonical.triangles]
    path.write_text("\n".join(lines))
    report = fit(path, output)
    assert report.remarks[0] == TRACKER_MESH_NOTE
    assert "the lips are one surface: they are cut where they meet when the face is opened" in report.remarks
    assert {"no eyeballs: put in", "no teeth: put in"} < set(report.remarks)
    points = read_ppc(output)
    known = len(canonical.vertices) > CONTROL_POINT_LANDMARKS
    np.testing.assert_allclose(points[known], canonical.vertices[CONTROL_POINT_LANDMARKS[known]], atol=1e-5)
    inner, pupil, outer = (
        points[CONTROL_POINT_INDEX[name], 0] for name in ("eye_inner_corner_l", "pupil_l", "eye_outer_corner_l")
    )
    assert inner < pupil < outer


def test_a_mesh_with_other_triangles_is_no_mesh_of_landmarks(canonical: CanonicalFace) -> None:
    numbers = np.random.default_rng(0).permutation(len(canonical.vertices)).astype(np.int32)
    empty = np.empty(0)
    shuffled = Mesh(canonical.vertices, numbers[canonical.triangles], empty, empty, empty, {})  # type: ignore[arg-type]
    assert points_of_landmark_mesh(shuffled, canonical) is None


@pytest.mark.slow
def test_a_mesh_without_a_face_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "ball.stl"
    trimesh.creation.icosphere(subdivisions=2).export(path)
    with pytest.raises(
        ConfError, match="no face was found with y up and z to the front: check the mesh, name its axes"
    ):
        fit(path, tmp_path / "ball.ppc", up="y", front="z")
    with pytest.raises(ConfError, match="--up y and --front -y are the same line"):
        fit(path, tmp_path / "ball.ppc", up="y", front="-y")
    assert not (tmp_path / "ball.ppc").exists()


@pytest.mark.slow
def test_a_flat_mesh_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "flat.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(ConfError, match="no face was found from any side"):
        fit(path, tmp_path / "flat.ppc")


@pytest.mark.slow
def test_errors_name_the_file_that_cannot_be_read_or_written(tmp_path: Path, canonical: CanonicalFace) -> None:
    with pytest.raises(FileFormatError, match=r"nobody\.obj"):
        fit(tmp_path / "nobody.obj", tmp_path / "nobody.ppc")
    path = tmp_path / "mask.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in canonical.vertices]
    path.write_text("\n".join([*lines, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in canonical.triangles)]))
    with pytest.raises(ConfError, match=r"cannot be written .*; name another file with -o"):
        fit(path, tmp_path / "no" / "folder.ppc")


def test_a_file_that_cannot_be_written_is_named_before_the_mesh_is_read(tmp_path: Path) -> None:
    (tmp_path / "face.obj").write_text("no mesh")
    with pytest.raises(
        ConfError, match=r"a\.ppc cannot be written \(No such file or directory\); name another file with -o"
    ):
        fit(tmp_path / "face.obj", tmp_path / "none" / "a.ppc")
