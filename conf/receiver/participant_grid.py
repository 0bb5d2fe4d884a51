"""Grid view: the faces of all participants side by side in one image.

One participant is drawn into the window. Of several, each frame draws those whose motion is new, at most one in
`DrawingDetail.interval`, the one that was drawn longest ago first; the others' cells are kept from an earlier frame.
"""

import math
from collections.abc import Collection, Mapping
from importlib import import_module
from itertools import pairwise
from typing import TYPE_CHECKING

import moderngl

from conf.face.deformation.face_model import FaceModel
from conf.face.head_pose import HeadPose
from conf.protocol.messages import MotionFrame
from conf.receiver.cell_cache import CellCache, CellContent, Viewport
from conf.receiver.heads.participant_heads import HeadOptions, Look, ParticipantHeads
from conf.receiver.resolution_control import DrawingDetail
from conf.receiver.stats_overlay import covered_width
from conf.render.auto_framing import AutoFraming, FrameArea, rest_pose
from conf.render.camera import ViewState
from conf.render.gpu_object import GpuObject
from conf.render.window import Window

if TYPE_CHECKING:
    from conf.receiver.portrait.portrait_renderer import PortraitRenderer

PLACEHOLDER_ID = -1  # participant that is drawn when there is none
BACKGROUND = (0.10, 0.11, 0.135)  # sRGB, behind the stats overlay beside several participants


def import_portraits() -> None:
    """Import what draws portraits, with SciPy, so that no frame has to wait for it later."""
    import_module("conf.receiver.portrait.portrait_renderer")


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
    """Draws the participants' motion, each on the face model or on their portrait, into a window.

    detail : how finely to draw; the resolution is that of heads, portraits are drawn in full
    looks : what each participant has told of its looks
    shows_photo : whether the last image shows a portrait
    withdrawn : participants whose portraits are not to be shown
    """

    def __init__(self, window: Window, face: FaceModel, heads: HeadOptions | None = None) -> None:
        """Prepare drawing. face : of everybody, or the default head if there are others"""
        self.detail = DrawingDetail()
        self.withdrawn: Collection[int] = ()
        self.looks: dict[int, Look] = {}
        self.shows_photo = False
        self._window = window
        self._heads = ParticipantHeads(window.ctx, face, heads or HeadOptions())
        self._framing: dict[int, AutoFraming] = {}
        self._portraits: dict[int, PortraitRenderer] = {}
        self._objects: dict[int, int] = {}  # received, of each participant's portrait
        self._cache: CellCache | None = None
        self._insets: dict[int, AutoFraming] = {}  # by participants that are drawn beside those of `draw`

    def receive_portrait_object(self, participant: int, data: bytes) -> None:
        """Add an object of a participant's portrait; an invalid one is ignored."""
        if participant not in self._portraits:
            from conf.receiver.portrait.portrait_renderer import PortraitRenderer  # with SciPy
            from conf.receiver.portrait.portrait_store import PortraitStore

            self._portraits[participant] = PortraitRenderer(self._window.ctx, PortraitStore())
        self._portraits[participant].store.receive(data)
        self._objects[participant] = self._objects.get(participant, 0) + 1

    def forget(self, participant: int) -> None:
        """Release what is known of a participant's looks: somebody else may come in its place."""
        self._framing.pop(participant, None)
        self.looks.pop(participant, None)
        self._objects.pop(participant, None)
        if portrait := self._portraits.pop(participant, None):
            portrait.release()

    def draw(self, frames: Mapping[int, MotionFrame | None], view: ViewState, now: float) -> dict[int, Viewport]:
        """Draw one image of each participant's frame; None, or no participant, is the neutral face.

        Returns the cell of each participant.
        """
        self._framing = {participant: self._framing.get(participant, AutoFraming()) for participant in frames}
        for gone in self._portraits.keys() - frames.keys() - self._insets.keys():
            self._portraits.pop(gone).release()
            self._objects.pop(gone)
        self._heads.scale = self.detail.scale
        apart = {participant: self.looks[participant] for participant in self._insets if participant in self.looks}
        self._heads.update({who: self.looks.get(who, Look()) for who in frames}, now, apart=apart)
        self.shows_photo = any(self._shows_photo(participant, frame, view) for participant, frame in frames.items())
        drawn, covered = frames or {PLACEHOLDER_ID: None}, self._covered(view)
        rectangles = layout_grid(len(drawn), self._window.size, left=covered if len(drawn) > 1 else 0)
        cells = dict(zip(drawn, rectangles, strict=True))
        if len(drawn) > 1:
            self._draw_several(drawn, cells, view, now)
        else:
            ((participant, frame),) = drawn.items()
            area = FrameArea.of(self._window.size, covered=covered)
            content = self._content(participant, frame, view, now, area)
            self._draw_cell(participant, content, cells[participant], self._window.framebuffer)
        self._window.framebuffer.viewport = (0, 0, *self._window.size)
        return {participant: cells[participant] for participant in frames}

    def draw_inset(self, participant: int, frame: MotionFrame, cell: Viewport, now: float, *, photo: bool) -> None:
        """Draw one more participant over the image, centred, into a cell of it.

        photo : draw the portrait once it has arrived
        """
        area, view = FrameArea.of(cell[2:]), ViewState(portrait=photo)
        pose = HeadPose.from_vector(frame.pose)
        framing = self._insets.setdefault(participant, AutoFraming())
        if not self._shows_photo(participant, frame, view):
            pose = framing.frame(pose, now, area)
        content = CellContent(frame.displacements, pose, view, furrow=frame.furrow)
        self._draw_cell(participant, content, cell, self._window.framebuffer)
        self._window.framebuffer.viewport = (0, 0, *self._window.size)

    def release(self) -> None:
        for owned in (self._heads, *self._portraits.values(), *([self._cache] if self._cache else [])):
            owned.release()

    def _draw_several(
        self, frames: Mapping[int, MotionFrame | None], cells: dict[int, Viewport], view: ViewState, now: float
    ) -> None:
        """Draw the cells whose turn it is, then copy all of them into the window."""
        cache = self._cache
        if cache is None or (cache.cells, cache.size) != (cells, self._window.size):
            if cache is not None:
                cache.release()
            cache = self._cache = CellCache(self._window.ctx, cells, self._window.size)
            cache.framebuffer.clear(*BACKGROUND)
        due = math.ceil(len(cells) / self.detail.interval) if cache.is_complete else len(cells)
        for participant in cache.by_age():
            if not due:
                break
            cell = cells[participant]
            content = self._content(participant, frames[participant], view, now, FrameArea.of(cell[2:]))
            if not cache.shows(participant, content):
                self._draw_cell(participant, content, cell, cache.framebuffer)
                cache.on_drawn(participant, content)
                due -= 1
        cache.copy_to(self._window.framebuffer)
        self._window.framebuffer.use()

    def _content(
        self, participant: int, frame: MotionFrame | None, view: ViewState, now: float, area: FrameArea
    ) -> CellContent:
        """Return what a participant's cell is to show. area : of the cell in which the head is kept"""
        is_photo = self._shows_photo(participant, frame, view)
        version = (self.detail.scale, is_photo, self._objects.get(participant, 0), self._heads.version(participant))
        if frame is None:
            return CellContent(None, rest_pose(area), view, version)
        pose = HeadPose.from_vector(frame.pose)
        if view.centred and not is_photo:
            pose = self._framing[participant].frame(pose, now, area)
        return CellContent(frame.displacements, pose, view, version, 0.0 if is_photo else frame.furrow)

    def _draw_cell(
        self, participant: int, content: CellContent, cell: Viewport, framebuffer: moderngl.Framebuffer
    ) -> None:
        """Draw a participant's portrait, or the face with the participant's motion."""
        framebuffer.viewport = cell
        displacements, pose, view = content.displacements, content.pose, content.view
        if displacements is not None and (photo := self._portrait(participant, view)):
            photo.draw(displacements, pose, view, framebuffer)
            return
        self._heads.draw(participant, displacements, pose, view, framebuffer, furrow=content.furrow)

    def _portrait(self, participant: int, view: ViewState) -> "PortraitRenderer | None":
        """Return the portrait to draw a participant's motion with, None for the face model."""
        portrait = None if participant in self.withdrawn else self._portraits.get(participant)
        return portrait if view.portrait and portrait and portrait.ready else None

    def _shows_photo(self, participant: int, frame: MotionFrame | None, view: ViewState) -> bool:
        return frame is not None and self._portrait(participant, view) is not None

    def _covered(self, view: ViewState) -> int:
        """Return the width, in pixels from the left, that the stats overlay covers: at most half of the image."""
        width = covered_width(self._window.size, self._window.pixel_ratio) if view.stats and view.centred else 0.0
        return min(round(width), self._window.size[0] // 2)
