import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import FileFormatError
from conf.face.default_head import DEFAULT_HEAD
from conf.face.deformation.blendshapes import load_blendshapes
from conf.face.deformation.rig_json import load_rig
from conf.face.formats.ppc import read_ppc
from conf.face.mesh.mesh import Mesh, load_mesh
from tests.support.sheet_face import SheetFace

RIG = DEFAULT_HEAD.with_name("rig.json")


@pytest.fixture(scope="module")
def head() -> tuple[Mesh, np.ndarray]:
    return load_mesh(DEFAULT_HEAD), read_ppc(DEFAULT_HEAD.with_suffix(".ppc"))


def test_the_default_head_has_two_eyes_and_a_jaw(head: tuple[Mesh, np.ndarray]) -> None:
    mesh, points = head
    rig = load_rig(RIG, mesh, points)
    assert [eye.pupil for eye in rig.eyes] == [16, 17]
    assert all(len(eye.vertices) and len(eye.lids) for eye in rig.eyes)
    assert rig.jaw is not None
    assert rig.jaw.vertices.tolist() == mesh.group_vertices("teeth_lower", "tongue").tolist()
    assert set(rig.jaw.weights) == {1.0}
    assert not rig.jaw.point_weights.any()
    assert len(rig.anchors) >= 10


def test_with_sculpted_shapes_the_skin_follows_the_jaw_by_shares(head: tuple[Mesh, np.ndarray]) -> None:
    mesh, points = head
    shapes = load_blendshapes(DEFAULT_HEAD.with_name("shapes.npz"), len(mesh.vertices))
    jaw = load_rig(RIG, mesh, points, shapes).jaw
    assert jaw is not None
    assert jaw.point_weights[0] > 0.9  # the chin
    assert jaw.point_weights[26:32] == pytest.approx(0)  # the brows
    assert 0 < jaw.weights.min() and jaw.weights.max() <= 1.0


def test_a_mesh_without_the_groups_has_nothing_rigid(tmp_path: Path, face: SheetFace) -> None:
    path = tmp_path / "rig.json"
    path.write_text(json.dumps({"anchors": [[0, 0, 0]]}))
    rig = load_rig(path, face.mesh, face.points)
    assert rig.eyes == ()
    assert rig.jaw is None
    assert len(rig.rigid) == 0


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "7",
        '{"eye_l": 3}',
        '{"jaw": {"centre": [0, 0, 0]}}',
        '{"anchors": [[1, 2]]}',
        '{"anchors": [[1e9, 0, 0]]}',
        '{"anchors": [["x", 0, 0]]}',
        '{"eye_l": {"centre": [NaN, 0, 0]}}',
        "[" * 100_000,
        '{"anchors": null}',
    ],
)
def test_what_is_no_rig_is_the_one_error(tmp_path: Path, face: SheetFace, text: str) -> None:
    path = tmp_path / "rig.json"
    path.write_text(text)
    with pytest.raises(FileFormatError, match="expected a rig: eyes, jaw and anchors"):
        load_rig(path, face.mesh, face.points)


@given(
    st.recursive(
        st.none() | st.floats() | st.text(max_size=3),
        lambda inner: (
            st.lists(inner, max_size=4)
            | st.dictionaries(
                st.sampled_from(["eye_l", "eye_r", "jaw", "centre", "axis", "anchors"]), inner, max_size=4
            )
        ),
        max_leaves=12,
    )
)
def test_any_json_gives_a_rig_or_the_one_error(
    tmp_path_factory: pytest.TempPathFactory, face: SheetFace, value: object
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.json"
    path.write_text(json.dumps(value))
    try:
        load_rig(path, face.mesh, face.points)
    except FileFormatError:
        pass
