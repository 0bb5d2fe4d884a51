"""The face that is animated: a mesh from any file, brought to model centimetres, and its control points if known."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

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

HEIGHT_CM = 26.0  # a mesh whose eyes are not known yet is taken for a head of this height
DEFAULT_AXES = ORIENTATIONS[0]


@dataclass(frozen=True)
class FaceDocument:
    """A mesh and where its control points are.

    source : the mesh as its file has it
    mesh : in model centimetres; nearly so while the control points are not known
    points : (n, 3) control points in the same frame, or None
    placement : what carries the file's coordinates to this frame
    axes : the file's axes towards the crown and towards the nose, as long as the points do not tell
    rig : what turns by itself; shapes : what the shipped head has beside its mesh
    """

    path: Path
    source: Mesh
    mesh: Mesh
    points: NDArray[np.float64] | None = None
    placement: SimilarityTransform = IDENTITY
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
        return OperatorBuilder(self.mesh, self.points, self.rig, self.shapes, file_to_model=self.placement)

    def to_file(self, places: NDArray[np.floating], /) -> NDArray[np.float64]:
        """Return (..., 3) places in the frame and unit of the mesh's file."""
        return self.placement.inverse_apply(np.asarray(places, np.float64))


def open_face_document(
    path: Path | None = None, ppc: Path | None = None, /, *, up: str | None = None, front: str | None = None
) -> FaceDocument:
    """Open a mesh, None for the shipped head; its control points from a PPC file, or from the one beside it.

    up, front : the mesh's axes towards the crown and towards the nose, such as "z" and "-y", as long as no points tell
    Raises FileFormatError if a file is not what it should be, ConfError if the control points are no face.
    """
    path = DEFAULT_HEAD if path is None else path
    mesh = load_mesh(path)
    if ppc is None and path.with_suffix(".ppc").exists():
        ppc = path.with_suffix(".ppc")
    subject = FaceDocument(path, mesh, mesh)
    if subject.is_default:
        shapes = load_blendshapes(path.with_name("shapes.npz"), len(mesh.vertices))
        return with_points(replace(subject, shapes=shapes), read_ppc(ppc or path.with_suffix(".ppc")))
    return with_axes(subject, up, front) if ppc is None else with_points(subject, read_ppc(ppc))


def with_points(subject: FaceDocument, in_file: NDArray[np.float64], /) -> FaceDocument:
    """Return the subject with its control points, (n, 3) in the file's frame, its eyes where the shipped head's are.

    Raises ConfError if the points cannot be those of this face.
    """
    try:
        if subject.is_default:
            Fapu.measure(in_file)
            rig = build_rig(subject.source, in_file, default_joints(), subject.shapes)
            return replace(subject, points=in_file, rig=rig)
        own = prepare_face(subject.source, in_file)
    except ValueError as error:
        raise ConfError(f"these control points do not fit this face: {error}") from error
    return replace(subject, mesh=own.mesh, points=own.points, placement=own.file_to_model, rig=own.rig)


def with_axes(subject: FaceDocument, up: str | None, front: str | None, /) -> FaceDocument:
    """Return a subject without control points, upright, at the size of a head, in the middle.

    up, front : the file's axes towards the crown and towards the nose, None for what is usual
    Raises ConfError if both lie on one line.
    """
    axes = next(((u, f) for u, f in ORIENTATIONS if up in (None, u) and front in (None, f)), None)
    if axes is None:
        raise ConfError(f"up {up} and front {front} name one line: name two, such as y and z")
    turn = axes_rotation(*axes)
    turned = subject.source.vertices @ turn.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    scale = HEIGHT_CM / float(max(high[1] - low[1], (high - low).max() / 2, 1e-9))
    placement = SimilarityTransform(turn, scale, -(low + high) / 2 * scale)
    mesh = weld_vertices(replace(subject.source, vertices=placement.apply(subject.source.vertices)))
    return replace(subject, mesh=mesh, points=None, rig=None, placement=placement, axes=axes)


def save_points(path: Path, subject: FaceDocument, /) -> None:
    """Write the control points as PPC, in the file's frame.

    Raises ConfError if there are none yet or the file cannot be written.
    """
    if subject.points is None:
        raise ConfError("the control points are not placed yet: place all of them, then press OK")
    try:
        write_ppc(path, subject.to_file(subject.points))
    except OSError as error:
        raise ConfError(f"{path} cannot be written ({error.strerror}); choose another file or folder") from error
