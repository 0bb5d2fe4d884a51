"""The stage: every caller's face in one picture, side by side."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

from conf.face.deformation.face_model import FaceModel
from conf.face.head_pose import HeadPose
from conf.protocol.messages import MotionFrame
from conf.receiver.portrait.portrait_renderer import PortraitRenderer
from conf.receiver.portrait.portrait_store import Album
from conf.receiver.stats_overlay import covered_width
from conf.render.auto_framing import Area, Framer, rest
from conf.render.camera import View
from conf.render.face_renderer import FaceRenderer
from conf.render.window.glfw_window import GlfwWindow
from conf.render.window.offscreen import OffscreenWindow

Window = GlfwWindow | OffscreenWindow
Cell = tuple[int, int, int, int]  # x, y of the lower left corner, width, height, in pixels
NOBODY = -1
SURROUND = (0.10, 0.11, 0.135)  # sRGB: what lies behind the meter beside several callers


def grid(count: int, size: tuple[int, int], *, left: int = 0) -> list[Cell]:
    """Return a cell of the picture for each caller, in rows from the top, as square as the picture allows.

    The cells fill the picture: those of a last row that is not full are wider.
    size : width and height of the picture in pixels
    left : pixels at the left that stay free
    """
    width, height = size[0] - left, size[1]
    columns = min(range(1, count + 1), key=lambda columns: _awkward(columns, count, width / height))
    rows = math.ceil(count / columns)
    cells: list[Cell] = []
    for row in range(rows):
        top, bottom = height - height * row // rows, height - height * (row + 1) // rows
        across = min(columns, count - row * columns)
        edges = [left + width * i // across for i in range(across + 1)]
        cells += [(x, bottom, end - x, top - bottom) for x, end in pairwise(edges)]
    return cells


def _awkward(columns: int, count: int, aspect: float) -> float:
    """Return how far the cells are from squares, and how many places the last row lacks."""
    rows = math.ceil(count / columns)
    return abs(math.log(aspect * rows / columns)) + (rows * columns - count) / count


@dataclass(frozen=True)
class Portrait:
    """What has come of a caller's picture, and what draws it."""

    album: Album
    renderer: PortraitRenderer


class Stage:
    """Draws the callers' motion on one face model into a window."""

    def __init__(self, window: Window, face: FaceModel) -> None:
        self._window = window
        self._face = face
        self._renderer = FaceRenderer(window.ctx, face)
        self._framers: dict[int, Framer] = {}
        self._portraits: dict[int, Portrait] = {}

    def hang(self, caller: int, data: bytes) -> None:
        """Take a part of a caller's picture. Whatever is wrong with it, the call goes on."""
        if caller not in self._portraits:
            album = Album()
            self._portraits[caller] = Portrait(album, PortraitRenderer(self._window.ctx, album))
        self._portraits[caller].album.receive(data)

    def draw(self, frames: Mapping[int, MotionFrame | None], view: View, now: float) -> dict[int, Cell]:
        """Draw one picture: each caller's frame, by the caller's number; None or nobody is the neutral face.

        Returns the cell of the picture that each caller has.
        """
        self._framers = {caller: self._framers.get(caller, Framer()) for caller in frames}
        for gone in self._portraits.keys() - frames.keys():
            self._take_down(gone)
        actors = list(frames.items()) or [(NOBODY, None)]
        covered = self._covered(view)
        cells = grid(len(actors), self._window.size, left=covered if len(actors) > 1 else 0)
        framebuffer = self._window.framebuffer
        framebuffer.clear(*SURROUND)
        for (caller, frame), cell in zip(actors, cells, strict=True):
            framebuffer.viewport = cell
            portrait = self._portraits.get(caller)
            if view.portrait and frame is not None and portrait and portrait.renderer.ready:
                portrait.renderer.draw(frame.displacements, HeadPose.from_vector(frame.pose), view, framebuffer)
                continue
            area = Area.of(cell[2:], covered=covered if len(actors) == 1 else 0)
            if frame is None:
                vertices, pose = self._face.neutral, rest(area)
            else:
                vertices, pose = self._face.deform(frame.displacements), HeadPose.from_vector(frame.pose)
                pose = self._framers[caller].place(pose, now, area) if view.centred else pose
            self._renderer.draw(vertices, pose, view, framebuffer)
        framebuffer.viewport = (0, 0, *self._window.size)
        return dict(zip(frames, cells, strict=False))

    def release(self) -> None:
        """Free everything on the card."""
        self._renderer.release()
        for caller in list(self._portraits):
            self._take_down(caller)

    def _take_down(self, caller: int) -> None:
        self._portraits.pop(caller).renderer.release()

    def _covered(self, view: View) -> int:
        """Return how many pixels from the left the meter takes: half the picture at the most."""
        width = covered_width(self._window.size, self._window.pixel_ratio) if view.meter and view.centred else 0.0
        return min(round(width), self._window.size[0] // 2)
