"""Grid view: the faces of all participants side by side in one image."""

import math
from collections.abc import Mapping
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
from conf.render.gpu_object import GpuObject
from conf.render.window import Window

Viewport = tuple[int, int, int, int]  # x, y of the lower left corner, width, height, pixels
PLACEHOLDER_ID = -1  # participant that is drawn when there is none
BACKGROUND = (0.10, 0.11, 0.135)  # sRGB, behind the stats overlay beside several participants


def layout_grid(count: int, size: tuple[int, int], *, left: int = 0) -> list[Viewport]:
    """Return a cell of the image for each participant, in rows from the top, as square as possible.

    The cells fill the image: those of an incomplete last row are wider.
    size : width and height of the image in pixels
    left : pixels at the left that stay free
    """
    width, height = size[0] - left, size[1]

    def cost(columns: int) -> float:  # deviation of the cells from squares, plus the fraction missing in the last row
        rows = math.ceil(count / columns)
        return abs(math.log(width / height * rows / columns)) + (rows * columns - count) / count

    columns = min(range(1, count + 1), key=cost)
    rows = math.ceil(count / columns)
    cells: list[Viewport] = []
    for row in range(rows):
        top, bottom = height - height * row // rows, height - height * (row + 1) // rows
        cells_in_row = min(columns, count - row * columns)
        edges = [left + width * i // cells_in_row for i in range(cells_in_row + 1)]
        cells += [(x, bottom, end - x, top - bottom) for x, end in pairwise(edges)]
    return cells


class ParticipantGrid(GpuObject):
    """Draws the participants' motion, each on the face model or on their portrait, into a window."""

    def __init__(self, window: Window, face: FaceModel) -> None:
        self._window = window
        self._face = face
        self._renderer = FaceRenderer(window.ctx, face)
        self._framing: dict[int, AutoFraming] = {}
        self._portraits: dict[int, PortraitRenderer] = {}
        self.shows_photo = False  # whether the last image shows a portrait

    def set_scale(self, scale: float) -> None:
        """Draw heads with this fraction of the window's resolution, 0 to 1; portraits are drawn in full."""
        self._renderer.scale = scale

    def receive_portrait_object(self, participant: int, data: bytes) -> None:
        """Add an object of a participant's portrait; an invalid one is ignored."""
        if participant not in self._portraits:
            self._portraits[participant] = PortraitRenderer(self._window.ctx, PortraitStore())
        self._portraits[participant].store.receive(data)

    def draw(self, frames: Mapping[int, MotionFrame | None], view: ViewState, now: float) -> dict[int, Viewport]:
        """Draw one image of each participant's frame; None, or no participant, is the neutral face.

        Returns the cell of each participant.
        """
        self._framing = {participant: self._framing.get(participant, AutoFraming()) for participant in frames}
        for gone in self._portraits.keys() - frames.keys():
            self._portraits.pop(gone).release()
        self.shows_photo = False
        participants = list(frames.items()) or [(PLACEHOLDER_ID, None)]
        covered = self._covered(view)
        cells = layout_grid(len(participants), self._window.size, left=covered if len(participants) > 1 else 0)
        framebuffer = self._window.framebuffer
        if covered and len(participants) > 1:
            framebuffer.clear(*BACKGROUND)
        for (participant, frame), cell in zip(participants, cells, strict=True):
            framebuffer.viewport = cell
            portrait = self._portraits.get(participant)
            if view.portrait and frame is not None and portrait and portrait.ready:
                self.shows_photo = True
                portrait.draw(frame.displacements, HeadPose.from_vector(frame.pose), view, framebuffer)
                continue
            area = FrameArea.of(cell[2:], covered=covered if len(participants) == 1 else 0)
            if frame is None:
                vertices, pose = self._face.neutral, rest_pose(area)
            else:
                vertices, pose = self._face.deform(frame.displacements), HeadPose.from_vector(frame.pose)
                pose = self._framing[participant].frame(pose, now, area) if view.centred else pose
            self._renderer.draw(vertices, pose, view, framebuffer, participant=participant)
        framebuffer.viewport = (0, 0, *self._window.size)
        return dict(zip(frames, cells, strict=False))

    def release(self) -> None:
        for owned in (self._renderer, *self._portraits.values()):
            owned.release()

    def _covered(self, view: ViewState) -> int:
        """Return the width, in pixels from the left, that the stats overlay covers: at most half of the image."""
        width = covered_width(self._window.size, self._window.pixel_ratio) if view.stats and view.centred else 0.0
        return min(round(width), self._window.size[0] // 2)
