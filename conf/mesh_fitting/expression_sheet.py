"""Draw a face with four expressions in one image, to check a fit by eye."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.errors import ConfError
from conf.face.animation.action_units import Intensity, combine_action_units
from conf.face.deformation.face_model import FaceModel
from conf.face.fitting.custom_face import prepare_face
from conf.face.formats.ppc import read_ppc
from conf.face.loading import build_face
from conf.face.mesh.mesh import load_mesh
from conf.mesh_fitting.multiview import FRONT, camera_pose
from conf.render.camera import ViewState
from conf.render.face_renderer import FaceRenderer
from conf.render.window.offscreen import OffscreenWindow

EXPRESSIONS: dict[str, dict[int, Intensity]] = {  # name -> action units
    "neutral": {},
    "blink": {45: 1.0},
    "open mouth": {26: 1.0},
    "smile": {6: 0.7, 12: 1.0, 16: 0.5, 26: 0.15},
}
CELL = 640  # width and height of each of the four drawings, px
FACE_CM, CENTRE = 22.0, (0.0, -0.5)  # height of a drawing and its centre, model centimetres
_COLUMNS = 2
_LABEL_POSITION, _LABEL_SIZE, _LABEL_COLOUR = (16, 34), 0.8, (255, 255, 255)


def draw_expressions(face: FaceModel) -> NDArray[np.uint8]:
    """Return (2 CELL, 2 CELL, 3) uint8 BGR: the face with each of EXPRESSIONS, in rows. Raises GraphicsError."""
    cells = []
    pose = camera_pose(FRONT, height=FACE_CM, centre=CENTRE)
    with OffscreenWindow(CELL, CELL) as window, FaceRenderer(window.ctx, face) as renderer:
        for name, units in EXPRESSIONS.items():
            window.begin()
            renderer.draw(face.deform(combine_action_units(units)), pose, ViewState(), window.framebuffer)
            window.end()
            cell = np.ascontiguousarray(window.read())
            cv2.putText(
                cell, name, _LABEL_POSITION, cv2.FONT_HERSHEY_SIMPLEX, _LABEL_SIZE, _LABEL_COLOUR, 2, cv2.LINE_AA
            )
            cells.append(cell)
    rows = [np.hstack(cells[i : i + _COLUMNS]) for i in range(0, len(cells), _COLUMNS)]
    return np.asarray(np.vstack(rows), dtype=np.uint8)


def draw_fitted_face(face: Path, points: Path) -> NDArray[np.uint8]:
    """Return the drawings of `draw_expressions` of a mesh file with the control points of a PPC file.

    Raises FileFormatError, GraphicsError, and ConfError if the points are not those of the mesh.
    """
    try:
        prepared = prepare_face(load_mesh(face), read_ppc(points))
    except ValueError as error:
        raise ConfError(f"{face} cannot be drawn with the points found: {error}") from error
    return draw_expressions(build_face(prepared.mesh, prepared.points, rig=prepared.rig))
