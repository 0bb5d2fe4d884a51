"""`conf fit`: place the control points on any face mesh by itself.

The mesh is drawn, the tracker says where it sees the control points, and `face.fitting.point_fitting` puts them on it.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import ConfError
from conf.face.control_points import CONTROL_POINT_LANDMARKS, PUPILS
from conf.face.fitting.face_prior import load_prior
from conf.face.fitting.point_fitting import FittedPoints, fit_control_points
from conf.face.formats.ppc import write_ppc
from conf.face.mesh.axes import ORIENTATIONS
from conf.face.mesh.mesh import Mesh, load_mesh
from conf.mesh_fitting.face_search import Progress, find_face
from conf.sender.tracking.canonical_face import CanonicalFace, read_canonical_face
from conf.sender.tracking.model_files import fetch_models

TRACKER_MESH_NOTE = "a mesh of the tracker's own landmarks: its vertices are the control points"
_EYE_RINGS = ((263, 362, 386, 374), (33, 133, 159, 145))  # corners and lids of the left and the right eye


@dataclass(frozen=True)
class FitReport:
    """What was found on a face mesh.

    up, front : the mesh's axis towards the crown and towards the nose; empty where they did not matter
    eye_distance : between the pupils, in the file's unit
    lip_lines : at how many of three places the lips were seen to meet or part
    lid_edges : of how many of four lids the edge was seen
    eyeballs : how many eyes are shells of their own
    mouth_open : whether the mesh is cut between the lips
    remarks : what is missing, and what follows from it
    """

    face: str
    output: str
    up: str
    front: str
    eye_distance: float
    lip_lines: int
    lid_edges: int
    eyeballs: int
    mouth_open: bool
    remarks: tuple[str, ...]


def fit(
    face: Path, output: Path, *, up: str | None = None, front: str | None = None, on_progress: Progress | None = None
) -> FitReport:
    """Place the control points on a mesh and write them as a PPC file in the mesh's own axes and unit.

    up, front : the mesh's axis towards the crown and towards the nose, such as "y" or "-z"; None finds it
    Raises FileFormatError if the file is no mesh, ConfError if no face is seen in it, GraphicsError, ModelError.
    """
    mesh = load_mesh(face)
    known = points_of_landmark_mesh(mesh, read_canonical_face(fetch_models()))
    if known is not None:
        placement, axes = FittedPoints(known, 3, 4, 0, False), ("", "")
    else:
        placement, axes = find_points(mesh, face, (up, front), on_progress)
    remarks = ((TRACKER_MESH_NOTE,) if known is not None else ()) + _remarks(placement)
    try:
        write_ppc(output, placement.points)
    except OSError as error:
        raise ConfError(f"{output} cannot be written ({error.strerror}): name another file with -o") from error
    left, right = placement.points[PUPILS]
    return FitReport(
        str(face), str(output), *axes, float(np.linalg.norm(left - right)),
        placement.lip_lines, placement.lid_edges, placement.eyeballs, placement.mouth_open, remarks,
    )  # fmt: skip


def find_points(
    mesh: Mesh, path: Path, asked: tuple[str | None, str | None], on_progress: Progress | None = None
) -> tuple[FittedPoints, tuple[str, str]]:
    """Return the control points in the mesh's own coordinates, and how it stands. Raises ConfError: no face is seen."""
    up, front = asked
    axes = [(u, f) for u, f in ORIENTATIONS if up in (None, u) and front in (None, f)]
    if not axes:
        raise ConfError(f"--up {up} and --front {front} name one line: name two, such as --up y --front z")
    prior = load_prior()
    sitting = find_face(mesh, prior, axes=axes, on_progress=on_progress)
    if sitting is None:
        tried = "from any side" if len(axes) > 1 else f"with {up} up and {front} to the front"
        raise ConfError(
            f"{path}: no face is seen {tried}: check the mesh, name its axes towards crown and nose with --up and "
            "--front, or place the points by hand in `conf animate`"
        )
    placement = fit_control_points(sitting.observed, sitting.mesh.vertices, sitting.mesh.triangles, prior)
    points = sitting.frame.inverse_apply(placement.points)
    return replace(placement, points=points), sitting.axes


def points_of_landmark_mesh(mesh: Mesh, canonical: CanonicalFace) -> NDArray[np.float64] | None:
    """Return the (n, 3) control points of a mesh whose vertices are the tracker's landmarks; None for any other."""
    count = len(canonical.vertices)
    if len(mesh.vertices) < count or len(mesh.triangles) < len(canonical.triangles):
        return None
    theirs, ours = ({tuple(sorted(t)) for t in m.triangles.tolist()} for m in (mesh, canonical))
    if not ours <= theirs or max(map(max, theirs)) > CONTROL_POINT_LANDMARKS.max():
        return None
    points: NDArray[np.float64] = mesh.vertices[np.minimum(CONTROL_POINT_LANDMARKS, len(mesh.vertices) - 1)]
    if len(mesh.vertices) <= CONTROL_POINT_LANDMARKS.max():  # without irises
        points[PUPILS] = [mesh.vertices[list(ring)].mean(axis=0) for ring in _EYE_RINGS]
    return points


def _remarks(placement: FittedPoints) -> tuple[str, ...]:
    missing = {
        "no line was found between the lips: check the inner lip points": placement.lip_lines == 0,
        "the lips are one surface: they are cut where they meet when the face is opened": not placement.mouth_open,
        "no eyeballs were found: empty sockets get new ones, other eyes cannot turn": placement.eyeballs < 2,
        "the edges of the lids are not sharp: check the lid points": placement.lid_edges < 2,
    }
    return tuple(text for text, holds in missing.items() if holds)
