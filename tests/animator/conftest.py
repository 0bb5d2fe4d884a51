"""The shipped head as a subject, and a mesh file that nobody knows the control points of."""

from pathlib import Path

import numpy as np
import pytest

from conf.animator.builder import FaceBuilder
from conf.animator.obj_file import write_obj
from conf.animator.subject import Subject, open_subject
from conf.face.head import Deformer, FaceModel

TO_FILE = (25.0, np.array([3.0, 1500.0, -8.0]))  # scale and shift of the stranger's file


@pytest.fixture(scope="session")
def subject() -> Subject:
    """The shipped head."""
    return open_subject()


@pytest.fixture(scope="session")
def head(subject: Subject) -> FaceModel:
    """The shipped head's model."""
    return FaceBuilder(subject).build(Deformer())


@pytest.fixture(scope="session")
def stranger(subject: Subject, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The shipped head as a mesh file of another unit, without control points."""
    path = tmp_path_factory.mktemp("stranger") / "stranger.obj"
    scale, shift = TO_FILE
    write_obj(path, subject.mesh, subject.mesh.vertices * scale + shift)
    return path
