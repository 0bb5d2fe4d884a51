"""Find the control points of any face mesh.

The mesh is rendered, the tracker finds landmarks in the images, and face.fitting.point_fitting puts the control points
on the surface.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.atomic_write import check_writable, report_write_errors
from conf.errors import ConfError
from conf.face.control_points import CONTROL_POINT_LANDMARKS, PUPILS
from conf.face.fitting.custom_face import prepare_face
from conf.face.fitting.face_prior import load_prior
from conf.face.fitting.point_fitting import FittedPoints, fit_control_points
from conf.face.formats.ppc import write_ppc
from conf.face.mesh.axes import ORIENTATIONS
from conf.face.mesh.mesh import Mesh, load_mesh
from conf.mesh_fitting.face_search import TRACKED, Progress, find_face
from conf.sender.tracking.canonical_face import CanonicalFace, load_canonical_face

TRACKER_MESH_NOTE = "a mesh of the tracker's own landmarks: its vertices are the control points"
_EYE_RINGS = ((263, 362, 386, 374), (33, 133, 159, 145))  # landmarks of corners and lids of the left and the right eye

_OUTPUT_ADVICE = "name another file with -o"


@dataclass(frozen=True)
class FitReport:
    """The result of a fit.

    up, front : the mesh's axis towards the crown and towards the nose; empty if they did not matter
    eye_distance : between the pupils, in the file's unit
    lip_lines : at how many of three positions the line between the lips was found
    lid_edges : of how many of four lids the edge was found
    eyeballs : number of eyes that are separate shells
    mouth_open : whether the mesh is cut between the lips
    remarks : what is missing, and the consequence
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
    """Find the control points of a mesh file and write them as a PPC file, in the mesh's own axes and unit.

    up, front : the mesh's axis towards the crown and towards the nose, such as "y" or "-z"; None searches for it
    Raises FileFormatError if the file is no mesh, ConfError if no face is found in it, GraphicsError, ModelError.
    """
    if face.exists():
        check_writable(output, advice=_OUTPUT_ADVICE)
    fitted, axes, remarks = find_points(face, (up, front), on_progress)
    with report_write_errors(output, advice=_OUTPUT_ADVICE):
        write_ppc(output, fitted.points)
    left, right = fitted.points[PUPILS]
    return FitReport(
        str(face), str(output.absolute()), *axes, float(np.linalg.norm(left - right)),
        fitted.lip_lines, fitted.lid_edges, fitted.eyeballs, fitted.mouth_open, remarks,
    )  # fmt: skip


def find_points(
    path: Path, axes: tuple[str | None, str | None], on_progress: Progress | None = None
) -> tuple[FittedPoints, tuple[str, str], tuple[str, ...]]:
    """Return the control points of a mesh file in its own coordinates, its axes (up, front), and remarks.

    axes : the axes that the user named
    Raises what `fit` raises.
    """
    mesh, (up, front) = load_mesh(path), axes
    known = points_of_landmark_mesh(mesh, load_canonical_face())
    if known is not None:
        fitted = FittedPoints(known, 3, 4, 0, False)
        return fitted, ("", ""), (*mesh.notes, TRACKER_MESH_NOTE, *_remarks(fitted, mesh))
    candidates = [(u, f) for u, f in ORIENTATIONS if up in (None, u) and front in (None, f)]
    if not candidates:
        raise ConfError(f"--up {up} and --front {front} are the same line: name two, such as --up y --front z")
    prior = load_prior()
    search = find_face(mesh, prior, axes=candidates, on_progress=on_progress)
    if search is None:
        tried = "from any side" if len(candidates) > 1 else f"with {up} up and {front} to the front"
        raise ConfError(
            f"{path}: no face was found {tried}: check the mesh, name its axes towards crown and nose with --up and "
            "--front, or set the points by hand in `conf animate`"
        )
    if on_progress:
        on_progress(TRACKED, "fitting the control points to the surface")
    fitted = fit_control_points(search.observed, search.mesh.vertices, search.mesh.triangles, prior)
    fitted = replace(fitted, points=search.frame.inverse_apply(fitted.points))
    if on_progress:
        on_progress((1 + TRACKED) / 2, "looking for eyes, mouth and teeth")
    return fitted, search.axes, (*mesh.notes, *_remarks(fitted, mesh))


def points_of_landmark_mesh(mesh: Mesh, canonical: CanonicalFace) -> NDArray[np.float64] | None:
    """Return the (n, 3) control points of a mesh whose vertices are the tracker's landmarks; None for any other."""
    count = len(canonical.vertices)
    if len(mesh.vertices) < count or len(mesh.triangles) < len(canonical.triangles):
        return None
    triangles, expected = ({tuple(sorted(t)) for t in m.triangles.tolist()} for m in (mesh, canonical))
    if not expected <= triangles or max(map(max, triangles)) > CONTROL_POINT_LANDMARKS.max():
        return None
    points: NDArray[np.float64] = mesh.vertices[np.minimum(CONTROL_POINT_LANDMARKS, len(mesh.vertices) - 1)]
    if len(mesh.vertices) <= CONTROL_POINT_LANDMARKS.max():  # without irises
        points[PUPILS] = [mesh.vertices[list(ring)].mean(axis=0) for ring in _EYE_RINGS]
    return points


def _remarks(fitted: FittedPoints, mesh: Mesh) -> tuple[str, ...]:
    missing = {
        "no line was found between the lips: check the inner lip points": fitted.lip_lines == 0,
        "the lips are one surface: they are cut where they meet when the face is opened": not fitted.mouth_open,
        "the edges of the lids are not sharp: check the lid points": fitted.lid_edges < 2,
    }
    try:
        parts = prepare_face(mesh, fitted.points).remarks
    except ValueError as error:
        parts = (f"the face cannot be animated yet: {error}",)
    return (*(text for text, holds in missing.items() if holds), *parts)
