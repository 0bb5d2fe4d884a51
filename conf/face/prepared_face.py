"""Faces ready to be deformed, from the user's cache: a head that comes with the program opens at once.

Reading a head's files and building its rig takes half as long as all else before the first image of a call, and imports
SciPy, which takes as long again. Faces from elsewhere consist of files that their names do not tell; these are loaded.
"""

from pathlib import Path

from conf.disk_cache import cache_key, cached, folder_state, source_state
from conf.face.default_head import DEFAULT_HEAD
from conf.face.deformation.constraints.upper_teeth import UpperTeeth
from conf.face.deformation.eyelids import Lashes, LidCover
from conf.face.deformation.face_model import FaceModel
from conf.face.deformation.rig import Eye, EyelidHelpers, Jaw, Rig
from conf.face.formats.mtl import MeshMaterial
from conf.face.head_catalogue import DEFAULT_NUMBER, HEADS_BY_NUMBER, Head
from conf.face.mesh.mesh import Mesh
from conf.face.similarity import SimilarityTransform

_CLASSES = (
    FaceModel, Mesh, MeshMaterial, SimilarityTransform,
    Rig, Eye, Jaw, Lashes, LidCover, EyelidHelpers, UpperTeeth,
)  # fmt: skip


def prepared_face(path: Path | None = None, /) -> FaceModel:
    """Return the same as `load_face`. Raises FileFormatError if a file is missing or malformed."""

    def load() -> FaceModel:
        from conf.face.loading import load_face  # with SciPy

        return load_face(path)

    if path is not None and path.resolve() != DEFAULT_HEAD.resolve():
        return load()
    return prepared_head(HEADS_BY_NUMBER[DEFAULT_NUMBER])


def prepared_head(head: Head, /) -> FaceModel:
    """Return the same as `load_head`. Raises FileFormatError if a file is missing or malformed."""

    def load() -> FaceModel:
        from conf.face.loading import load_head  # with SciPy

        return load_head(head)

    folders = [folder_state(DEFAULT_HEAD.parent, "*")]
    if not head.is_default:
        folders.append(folder_state(head.path.parent, f"{head.name}.*"))
    return cached("faces", cache_key(source_state("face"), *folders), load, *_CLASSES)
