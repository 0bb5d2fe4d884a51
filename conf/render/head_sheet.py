"""Draw several heads side by side, each with its name."""

import math
from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.deformation.face_model import FaceModel
from conf.render.auto_framing import FrameArea, rest_pose
from conf.render.camera import ViewState
from conf.render.face_renderer import FaceRenderer
from conf.render.window.offscreen import OffscreenWindow

CELL = 320  # width and height of each drawing, px
COLUMNS = 3
_LABEL, _LABEL_SIZE, _LABEL_COLOUR = (12, 26), 0.65, (255, 255, 255)


def draw_heads(faces: Mapping[str, FaceModel]) -> NDArray[np.uint8]:
    """Return (rows x CELL, columns x CELL, 3) uint8 BGR: the neutral faces in rows. Raises GraphicsError."""
    columns = min(COLUMNS, len(faces))
    sheet = np.zeros((math.ceil(len(faces) / columns) * CELL, columns * CELL, 3), np.uint8)
    pose = rest_pose(FrameArea.of((CELL, CELL)))
    with OffscreenWindow(CELL, CELL) as window:
        for number, (name, face) in enumerate(faces.items()):
            row, column = divmod(number, columns)
            with FaceRenderer(window.ctx, face) as renderer:
                window.begin()
                renderer.draw(face.neutral, pose, ViewState(), window.framebuffer)
                window.end()
                cell = np.ascontiguousarray(window.read())
            cv2.putText(cell, name, _LABEL, cv2.FONT_HERSHEY_SIMPLEX, _LABEL_SIZE, _LABEL_COLOUR, 1, cv2.LINE_AA)
            sheet[row * CELL : (row + 1) * CELL, column * CELL : (column + 1) * CELL] = cell
    return sheet
