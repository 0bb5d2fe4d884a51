"""The edited face: a mesh from a file, converted to model centimetres, and its control points if they are known."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.atomic_write import report_write_errors
from conf.errors import ConfError
from conf.face.default_head import DEFAULT_HEAD, default_joints
from conf.face.deformation.blendshapes import Blendshapes, load_blendshapes
from conf.face.deformation.operator_builder import OperatorBuilder
from conf.face.deformation.rig import Rig
from conf.face.deformation.rig_builder import build_rig
from conf.face.fapu import Fapu
from conf.face.fitting.custom_face import prepare_face
from conf.face.formats.ppc import read_ppc, write_ppc
from conf.face.mesh.axes import ORIENTATIONS, axes_rotation
from conf.face.mesh.editing import weld_vertices
from conf.face.mesh.mesh import Mesh, load_mesh
from conf.face.similarity import IDENTITY, SimilarityTransform

HEIGHT_CM = 26.0  # assumed height of a head whose control points are not known
DEFAULT_AXES = ORIENTATIONS[0]


@dataclass(frozen=True)
class FaceDocument:
    """A mesh and its control points.

    source : the mesh in the frame and unit of its file
    mesh : in model centimetres; approximately so while the control points are not known
    points : (n, 3) control points, model centimetres, or None
    file_to_model : from the file's coordinates to the model's
    axes : the file's up and front axes, used until the control points are known
    rig : jaw and eyes; shapes : blendshapes of the shipped head
    """

    path: Path
    source: Mesh
    mesh: Mesh
    points: NDArray[np.float64] | None = None
    file_to_model: SimilarityTransform = IDENTITY
    axes: tuple[str, str] = DEFAULT_AXES
    rig: Rig | None = None
    shapes: Blendshapes | None = None

    @property
    def is_default(self) -> bool:
        """Whether this is the shipped head."""
        return self.path.resolve() == DEFAULT_HEAD.resolve()

    def operator_builder(self) -> OperatorBuilder:
        """Return the builder of this face's operators. Raises ValueError if it has no control points."""
        if self.points is None:
            raise ValueError("the face must have control points")
        return OperatorBuilder(self.mesh, self.points, self.rig, self.shapes, file_to_model=self.file_to_model)

    def to_file_coordinates(self, positions: NDArray[np.floating], /) -> NDArray[np.float64]:
        """Return (..., 3) positions in the frame and unit of the mesh's file."""
        return self.file_to_model.inverse_apply(np.asarray(positions, np.float64))


def open_face_document(
    path: Path | None = None, ppc: Path | None = None, /, *, up: str | None = None, front: str | None = None
) -> FaceDocument:
    """Open a mesh, None for the shipped head, with the control points of a PPC file or of the one beside the mesh.

    up, front : the mesh's axes such as "z" and "-y", used only without control points; None for the usual ones
    Raises FileFormatError if a file is not valid, ConfError if the control points do not fit the face.
    """
    path = DEFAULT_HEAD if path is None else path
    mesh = load_mesh(path)
    if ppc is None and path.with_suffix(".ppc").exists():
        ppc = path.with_suffix(".ppc")
    document = FaceDocument(path, mesh, mesh)
    if document.is_default:
        shapes = load_blendshapes(path.with_name("shapes.npz"), len(mesh.vertices))
        return with_points(replace(document, shapes=shapes), read_ppc(ppc or path.with_suffix(".ppc")))
    return with_axes(document, up, front) if ppc is None else with_points(document, read_ppc(ppc))


def with_points(document: FaceDocument, points: NDArray[np.float64], /) -> FaceDocument:
    """Return the document with its control points, and the mesh moved so that its eyes are the shipped head's.

    points : (n, 3) in the frame and unit of the mesh's file
    Raises ConfError if the points do not fit the face.
    """
    try:
        if document.is_default:
            Fapu.measure(points)
            rig = build_rig(document.source, points, default_joints(), document.shapes)
            return replace(document, points=points, rig=rig)
        face = prepare_face(document.source, points)
    except ValueError as error:
        raise ConfError(f"these control points do not fit this face: {error}") from error
    return replace(document, mesh=face.mesh, points=face.points, file_to_model=face.file_to_model, rig=face.rig)


def with_axes(document: FaceDocument, up: str | None, front: str | None, /) -> FaceDocument:
    """Return the document without control points, its mesh upright, centred and as high as a head.

    up, front : the file's axes, None for the usual ones
    Raises ConfError if both lie on one line.
    """
    axes = next(((u, f) for u, f in ORIENTATIONS if up in (None, u) and front in (None, f)), None)
    if axes is None:
        raise ConfError(f"up {up} and front {front} name one line: name two, such as y and z")
    rotation = axes_rotation(*axes)
    upright = document.source.vertices @ rotation.T
    low, high = upright.min(axis=0), upright.max(axis=0)
    scale = HEIGHT_CM / float(max(high[1] - low[1], (high - low).max() / 2, 1e-9))
    file_to_model = SimilarityTransform(rotation, scale, -(low + high) / 2 * scale)
    mesh = weld_vertices(replace(document.source, vertices=file_to_model.apply(document.source.vertices)))
    return replace(document, mesh=mesh, points=None, rig=None, file_to_model=file_to_model, axes=axes)


def save_points(path: Path, document: FaceDocument, /) -> None:
    """Write the control points as a PPC file in the frame and unit of the mesh's file.

    Raises ConfError if there are none or the file cannot be written.
    """
    if document.points is None:
        raise ConfError("the control points are not placed yet: place all of them, then press OK")
    with report_write_errors(path):
        write_ppc(path, document.to_file_coordinates(document.points))
