from pathlib import Path

import numpy as np
import pytest

from conf.animator.obj_file import write_obj
from conf.animator.subject import Subject
from conf.errors import ConfError
from conf.face.mesh import load_mesh


def test_a_written_mesh_is_read_as_it_was(tmp_path: Path, subject: Subject) -> None:
    write_obj(tmp_path / "a.obj", subject.mesh, subject.mesh.vertices)
    mesh = load_mesh(tmp_path / "a.obj")
    np.testing.assert_allclose(mesh.vertices, subject.mesh.vertices, atol=1e-5)
    np.testing.assert_array_equal(mesh.triangles, subject.mesh.triangles)
    for name, triangles in subject.mesh.groups.items():
        np.testing.assert_array_equal(mesh.groups[name], triangles)


def test_a_folder_that_is_not_there_is_named(tmp_path: Path, subject: Subject) -> None:
    with pytest.raises(ConfError, match=r"a\.obj cannot be written \(No such file or directory\)"):
        write_obj(tmp_path / "none" / "a.obj", subject.mesh, subject.mesh.vertices)
