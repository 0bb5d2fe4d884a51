"""The face that is animated: a mesh from any file, brought to model centimetres, and its control points if known."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import ConfError
from conf.face.control_points import PUPILS
from conf.face.fapu import Fapu
from conf.face.head import DEFAULT_HEAD
from conf.face.head_pose import ES0_CM
from conf.face.mesh import Mesh, load_mesh
from conf.face.ppc import read_ppc, write_ppc
from conf.face.rig import Rig
from conf.face.rig_file import load_rig
from conf.face.shapes import Shapes, load_shapes

EYE_MIDDLE = np.array([0.0, 2.845, 3.8])  # between the default head's pupils, model centimetres
HEIGHT_CM = 26.0  # a mesh whose eyes are not known yet is taken for a head of this height


@dataclass(frozen=True)
class Subject:
    """A mesh and where its control points are.

    mesh : in model centimetres; nearly so while the control points are not known
    points : (n, 3) control points in the same frame, or None
    scale, shift : the way from the file's frame to this one: x * scale + shift
    rig, shapes : what the shipped head has beside its mesh
    """

    path: Path
    mesh: Mesh
    points: NDArray[np.float64] | None
    scale: float = 1.0
    shift: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    rig: Rig | None = None
    shapes: Shapes | None = None

    @property
    def is_default(self) -> bool:
        """Whether this is the shipped head."""
        return self.path.resolve() == DEFAULT_HEAD.resolve()

    def to_file(self, places: NDArray[np.floating], /) -> NDArray[np.float64]:
        """Return (..., 3) places in the frame and unit of the mesh's file."""
        return np.asarray((places - self.shift) / self.scale, np.float64)


def open_subject(path: Path | None = None, ppc: Path | None = None, /) -> Subject:
    """Open a mesh, None for the shipped head; its control points from a PPC file, or from the one beside it.

    Raises FileFormatError if a file is not what it should be, ConfError if the control points are no face.
    """
    path = DEFAULT_HEAD if path is None else path
    mesh = load_mesh(path)
    if ppc is None and path.with_suffix(".ppc").exists():
        ppc = path.with_suffix(".ppc")
    subject = Subject(path, mesh, None)
    if subject.is_default:
        shapes = load_shapes(path.with_name("shapes.npz"), len(mesh.vertices))
        subject = replace(subject, shapes=shapes)
    elif ppc is None:
        return roughly_placed(subject)
    return place_points(subject, read_ppc(ppc if ppc else path.with_suffix(".ppc")))


def place_points(subject: Subject, in_file: NDArray[np.float64], /) -> Subject:
    """Return the subject with its control points, (n, 3) in the file's frame, its eyes where the shipped head's are.

    Raises ConfError if the points cannot be those of a face.
    """
    mesh = replace(subject.mesh, vertices=subject.to_file(subject.mesh.vertices))
    try:
        fapu = Fapu.measure(in_file)
    except ValueError as error:
        raise ConfError("these control points are no face: pupils, nose, lids and lips must lie apart") from error
    if subject.is_default:
        rig = load_rig(subject.path.with_name("rig.json"), mesh, in_file, _shapes_of(subject))
        return replace(subject, mesh=mesh, points=in_file, rig=rig, scale=1.0, shift=np.zeros(3))
    scale = ES0_CM / fapu.es0
    shift = EYE_MIDDLE - in_file[PUPILS].mean(axis=0) * scale
    return replace(
        subject,
        mesh=replace(mesh, vertices=mesh.vertices * scale + shift),
        points=in_file * scale + shift,
        scale=scale,
        shift=shift,
    )


def roughly_placed(subject: Subject, /) -> Subject:
    """Return a subject without control points at the size of a head, in the middle."""
    low, high = subject.mesh.vertices.min(axis=0), subject.mesh.vertices.max(axis=0)
    extent = float(max(high[1] - low[1], (high - low).max() / 2, 1e-9))
    scale = HEIGHT_CM / extent
    shift = -(low + high) / 2 * scale
    return replace(
        subject,
        mesh=replace(subject.mesh, vertices=subject.mesh.vertices * scale + shift),
        points=None,
        scale=scale,
        shift=shift,
    )


def save_points(path: Path, subject: Subject, /) -> None:
    """Write the control points as PPC, in the file's frame.

    Raises ConfError if there are none yet or the file cannot be written.
    """
    if subject.points is None:
        raise ConfError("the control points are not placed yet: place all of them, then press OK")
    try:
        write_ppc(path, subject.to_file(subject.points))
    except OSError as error:
        raise ConfError(f"{path} cannot be written ({error.strerror}); choose another file or folder") from error


def _shapes_of(subject: Subject) -> Shapes:
    if subject.shapes is None:
        raise ValueError("the shipped head must come with its shapes")
    return subject.shapes
