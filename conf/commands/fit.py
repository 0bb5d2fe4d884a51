"""`conf fit`: place the control points on any face mesh by itself.

The mesh is drawn, the tracker says where it sees the control points, and conf.face.placing puts them on the surface.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from conf.commands.sitting import Progress, observe
from conf.face.control_points import INDEX
from conf.face.face_prior import load_prior
from conf.face.mesh import load_mesh
from conf.face.orientation import turn_upright
from conf.face.placing import Placement, place_points
from conf.face.ppc import write_ppc


@dataclass(frozen=True)
class FitReport:
    """What was found on a face mesh.

    eye_distance : between the pupils, in the file's unit
    lip_lines : at how many of three places the lips were seen to meet or part
    lid_edges : of how many of four lids the edge was seen
    eyeballs : how many eyes are shells of their own
    """

    face: str
    output: str
    up: str
    front: str
    eye_distance: float
    lip_lines: int
    lid_edges: int
    eyeballs: int
    remarks: tuple[str, ...]


def fit(face: Path, output: Path, *, up: str = "y", front: str = "z", on_progress: Progress | None = None) -> FitReport:
    """Place the control points on a mesh and write them as a PPC file in the mesh's own axes and unit.

    up, front : the mesh's axis towards the crown and towards the nose
    Raises FileFormatError if the file is no mesh, ConfError if no face is seen in it, GraphicsError, ModelError.
    """
    turn = turn_upright(up, front)
    mesh = load_mesh(face)
    upright = replace(mesh, vertices=mesh.vertices @ turn.T)
    prior = load_prior()
    sitting = observe(upright, prior, name=str(face), on_progress=on_progress)
    placement = place_points(sitting.observed, sitting.mesh.vertices, sitting.mesh.triangles, prior)
    points = sitting.frame.undo(placement.points) @ turn
    write_ppc(output, points)
    if (up, front) != ("y", "z"):
        text = output.read_text(encoding="utf-8")
        output.write_text(f"# up: {up}\n# front: {front}\n{text}", encoding="utf-8")
    eyes = points[INDEX["pupil_l"]] - points[INDEX["pupil_r"]]
    return FitReport(
        str(face), str(output), up, front, float(np.linalg.norm(eyes)),
        placement.lip_lines, placement.lid_edges, placement.eyeballs, _remarks(placement),
    )  # fmt: skip


def _remarks(placement: Placement) -> tuple[str, ...]:
    """Say what is missing on the mesh, and what follows from it."""
    missing = {
        "no line was found between the lips: check the inner lip points": placement.lip_lines == 0,
        "the edges of the lids were not found: check the lid points": placement.lid_edges < 2,
        "no eyeballs of their own: the eyes will not turn": placement.eyeballs < 2,
    }
    return tuple(text for text, holds in missing.items() if holds)
