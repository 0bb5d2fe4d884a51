"""The stage: every caller's face in one picture, side by side."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

from conf.face.deformation.face_model import FaceModel
from conf.face.head_pose import HeadPose
from conf.protocol.messages import MotionFrame
from conf.receiver.portrait.portrait_renderer import PortraitRenderer
from conf.receiver.portrait.portrait_store import PortraitStore
from conf.receiver.stats_overlay import covered_width
from conf.render.auto_framing import AutoFraming, FrameArea, rest_pose
from conf.render.camera import ViewState
from conf.render.face_renderer import FaceRenderer
from conf.render.window.glfw_window import GlfwWindow
from conf.render.window.offscreen import OffscreenWindow

Window = GlfwWindow | OffscreenWindow
Viewport = tuple[int, int, int, int]  # x, y of the lower left corner, width, height, in pixels
PLACEHOLDER_ID = -1
SURROUND = (0.10, 0.11, 0.135)  # sRGB: what lies behind the meter beside several callers


def layout_grid(count: int, size: tuple[int, int], *, left: int = 0) -> list[Viewport]:
    """Return a cell of the picture for each caller, in rows from the top, as square as the picture allows.

    The cells fill the picture: those of a last row that is not full are wider.
    size : width and height of the picture in pixels
    left : pixels at the left that stay free
    """
    width, height = size[0] - left, size[1]
    columns = min(range(1, count + 1), key=lambda columns: _layout_cost(columns, count, width / height))
    rows = math.ceil(count / columns)
    cells: list[Viewport] = []
    for row in range(rows):
        top, bottom = height - height * row // rows, height - height * (row + 1) // rows
        across = min(columns, count - row * columns)
        edges = [left + width * i // across for i in range(across + 1)]
        cells += [(x, bottom, end - x, top - bottom) for x, end in pairwise(edges)]
    return cells


def _layout_cost(columns: int, count: int, aspect: float) -> float:
    """Return how far the cells are from squares, and how many places the last row lacks."""
    rows = math.ceil(count / columns)
    return abs(math.log(aspect * rows / columns)) + (rows * columns - count) / count


@dataclass(frozen=True)
class ParticipantPortrait:
    """What has come of a caller's picture, and what draws it."""

    album: PortraitStore
    renderer: PortraitRenderer


class ParticipantGrid:
    """Draws the callers' motion on one face model into a window."""

    def __init__(self, window: Window, face: FaceModel) -> None:
        self._window = window
        self._face = face
        self._renderer = FaceRenderer(window.ctx, face)
        self._framers: dict[int, AutoFraming] = {}
        self._portraits: dict[int, ParticipantPortrait] = {}

    def receive_portrait_object(self, caller: int, data: bytes) -> None:
        """Take a part of a caller's picture. Whatever is wrong with it, the call goes on."""
        if caller not in self._portraits:
            album = PortraitStore()
            self._portraits[caller] = ParticipantPortrait(album, PortraitRenderer(self._window.ctx, album))
        self._portraits[caller].album.receive(data)

    def draw(self, frames: Mapping[int, MotionFrame | None], view: ViewState, now: float) -> dict[int, Viewport]:
        """Draw one picture: each caller's frame, by the caller's number; None or nobody is the neutral face.

        Returns the cell of the picture that each caller has.
        """
        self._framers = {caller: self._framers.get(caller, AutoFraming()) for caller in frames}
        for gone in self._portraits.keys() - frames.keys():
            self._remove_portrait(gone)
        participants = list(frames.items()) or [(PLACEHOLDER_ID, None)]
        covered = self._covered(view)
        cells = layout_grid(len(participants), self._window.size, left=covered if len(participants) > 1 else 0)
        framebuffer = self._window.framebuffer
        framebuffer.clear(*SURROUND)
        for (caller, frame), cell in zip(participants, cells, strict=True):
            framebuffer.viewport = cell
            portrait = self._portraits.get(caller)
            if view.portrait and frame is not None and portrait and portrait.renderer.ready:
                portrait.renderer.draw(frame.displacements, HeadPose.from_vector(frame.pose), view, framebuffer)
                continue
            area = FrameArea.of(cell[2:], covered=covered if len(participants) == 1 else 0)
            if frame is None:
                vertices, pose = self._face.neutral, rest_pose(area)
            else:
                vertices, pose = self._face.deform(frame.displacements), HeadPose.from_vector(frame.pose)
                pose = self._framers[caller].frame(pose, now, area) if view.centred else pose
            self._renderer.draw(vertices, pose, view, framebuffer)
        framebuffer.viewport = (0, 0, *self._window.size)
        return dict(zip(frames, cells, strict=False))

    def release(self) -> None:
        """Free everything on the card."""
        self._renderer.release()
        for caller in list(self._portraits):
            self._remove_portrait(caller)

    def _remove_portrait(self, caller: int) -> None:
        self._portraits.pop(caller).renderer.release()

    def _covered(self, view: ViewState) -> int:
        """Return how many pixels from the left the meter takes: half the picture at the most."""
        width = covered_width(self._window.size, self._window.pixel_ratio) if view.meter and view.centred else 0.0
        return min(round(width), self._window.size[0] // 2)
