"""The four drawings of faces that lack parts: no hole, a dark mouth with teeth, lids that close, irises."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.errors import ConfError
from conf.face.animation.action_units import combine_action_units
from conf.face.control_points import CONTROL_POINT_INDEX, PUPILS
from conf.face.default_head import default_points
from conf.face.fitting.custom_face import prepare_face
from conf.face.formats.ppc import read_ppc, write_ppc
from conf.face.loading import build_face
from conf.face.mesh.mesh import load_mesh
from conf.mesh_fitting.expression_sheet import CELL, CENTRE, EXPRESSIONS, FACE_CM, draw_expressions, draw_fitted_face
from conf.mesh_fitting.fit import fit
from conf.mesh_fitting.multiview import FRONT, camera_pose
from conf.render.camera import ViewState, clip_matrix
from tests.support.modified_heads import EYEBALLS, MOUTH, face_without, head_without
from tests.support.visible_parts import between_lips, max_lid_gap

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("gl")]


def pixel(row: int, column: int, position: NDArray[np.floating]) -> tuple[int, int]:
    """Return row and column of a position (3,) in one of the four drawings."""
    clip = clip_matrix(camera_pose(FRONT, height=FACE_CM, centre=CENTRE), ViewState(), aspect=1.0)
    seen = clip @ [*position, 1.0]
    x, y = (seen[:2] / seen[3] * [0.5, -0.5] + 0.5) * CELL
    return row * CELL + round(y), column * CELL + round(x)


@pytest.mark.parametrize("missing", [(), EYEBALLS, MOUTH, (*EYEBALLS, *MOUTH)])
def test_a_head_without_some_parts_looks_alive(missing: tuple[str, ...]) -> None:
    face = face_without(*missing)
    image = draw_expressions(face)
    assert image.shape == (2 * CELL, 2 * CELL, 3)
    for pupil in PUPILS:
        y, x = pixel(0, 0, face.control_points[pupil])
        eye = image[y - 12 : y + 12, x - 20 : x + 20].max(axis=2)
        assert eye.min() < 60 and eye.max() > 180  # a dark pupil, and white or a catchlight
    opened = combine_action_units(EXPRESSIONS["open mouth"])
    points = face.deformed_points(opened)
    seen = between_lips(face, face.deform(opened), points)
    assert set(seen) <= {"mouth", "teeth_upper", "teeth_lower", "tongue"}
    lips = [CONTROL_POINT_INDEX[f"inner_lip_{lip}_mid"] for lip in ("upper", "lower")]
    y, x = pixel(1, 0, points[lips].mean(axis=0))
    skin_y, skin_x = pixel(1, 0, points[CONTROL_POINT_INDEX["chin_boss"]])
    assert (
        image[y - 4 : y + 4, x - 10 : x + 10].mean() < 0.6 * image[skin_y - 4 : skin_y + 4, skin_x - 4 :][:, :8].mean()
    )


@pytest.mark.parametrize("missing", [(), EYEBALLS])
def test_lids_close_along_their_whole_width(missing: tuple[str, ...]) -> None:
    face = face_without(*missing)
    shut = face.deform(combine_action_units(EXPRESSIONS["blink"]))
    for side in "lr":
        assert max_lid_gap(face, face.neutral, side) > 0.5
        assert max_lid_gap(face, shut, side) <= 0.08


def test_a_mesh_file_is_drawn_with_its_points(tmp_path: Path) -> None:
    mesh, points = head_without(*MOUTH), tmp_path / "face.ppc"
    lines = [f"v {x} {y} {z}" for x, y, z in mesh.vertices] + [f"f {a} {b} {c}" for a, b, c in mesh.triangles + 1]
    (tmp_path / "face.obj").write_text("\n".join(lines))
    write_ppc(points, default_points())
    assert draw_fitted_face(tmp_path / "face.obj", points).shape == (2 * CELL, 2 * CELL, 3)
    write_ppc(points, default_points() + np.array([0, 0, 50]))
    with pytest.raises(ConfError, match="cannot be drawn with the points found"):
        draw_fitted_face(tmp_path / "face.obj", points)


@pytest.mark.usefixtures("models")
def test_a_head_with_nested_eyeballs_tear_film_lashes_and_single_teeth(shared: Path, tmp_path: Path) -> None:
    path, output = shared / "faces" / "ict_head.obj", tmp_path / "ict.ppc"
    report = fit(path, output, up="y", front="z")
    assert report.eyeballs == 2 and report.lid_edges == 4
    assert any("cover the eyes" in remark for remark in report.remarks)
    prepared = prepare_face(load_mesh(path), read_ppc(output))
    face = build_face(prepared.mesh, prepared.points, rig=prepared.rig)
    for eye in prepared.rig.eyes:
        radius = np.linalg.norm(prepared.points[eye.pupil] - eye.centre)
        assert 1.5 < radius < 1.9 and len(eye.vertices) == 770 + 800
    assert {"teeth_upper", "teeth_lower", "mouth"} <= set(prepared.mesh.groups)
    shut = face.deform(combine_action_units(EXPRESSIONS["blink"]))
    assert max(max_lid_gap(face, shut, side) for side in "lr") <= 0.08
    opened = combine_action_units(EXPRESSIONS["open mouth"])
    assert set(between_lips(face, face.deform(opened), face.deformed_points(opened))) <= {
        "mouth", "teeth_upper", "teeth_lower",
    }  # fmt: skip
