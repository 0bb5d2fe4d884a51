"""Keep the image of each participant's cell, so that only cells whose content has changed are drawn again."""

from collections.abc import Mapping
from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.render.camera import ViewState
from conf.render.gpu_object import GpuObject

Viewport = tuple[int, int, int, int]  # x, y of the lower left corner, width, height, pixels
STILL = 1e-4  # rad, image heights or log scale: a pose that differs by less moves nothing by a tenth of a pixel
SAME_FURROW = 0.01  # a smaller change of the depth of furrows is not seen


@dataclass(frozen=True)
class CellContent:
    """What a cell shows.

    displacements : (n, 3) FAPU units; None for the neutral face
    version : what else the image depends on; equal for equal images
    furrow : depth of the furrows between the brows, 0 to 1
    """

    displacements: NDArray[np.float32] | None
    pose: HeadPose
    view: ViewState
    version: tuple[object, ...] = ()
    furrow: float = 0.0

    def looks_like(self, other: "CellContent") -> bool:
        """Return whether both give the same image."""
        if (self.view, self.version) != (other.view, other.version):
            return False
        if np.abs(self.pose.to_vector() - other.pose.to_vector()).max() >= STILL:
            return False
        if abs(self.furrow - other.furrow) >= SAME_FURROW:
            return False
        if self.displacements is None or other.displacements is None:
            return self.displacements is other.displacements
        return np.array_equal(self.displacements, other.displacements)


class CellCache(GpuObject):
    """An image of the window's size that keeps its cells from frame to frame.

    cells : by participant
    framebuffer : to draw cells into
    """

    def __init__(self, ctx: moderngl.Context, cells: Mapping[int, Viewport], size: tuple[int, int]) -> None:
        """size : width and height of the window, pixels"""
        self.cells = dict(cells)
        self.size = size
        self._ctx = ctx
        self._drawn: dict[int, CellContent] = {}  # the one that was drawn last is the last
        colour, depth = ctx.renderbuffer(size, 4), ctx.depth_renderbuffer(size)
        self.framebuffer = ctx.framebuffer(colour, depth)
        self._owned = (self.framebuffer, colour, depth)

    @property
    def is_complete(self) -> bool:
        """Whether every cell has been drawn."""
        return len(self._drawn) == len(self.cells)

    def by_age(self) -> list[int]:
        """Return the participants: those never drawn first, the one drawn last at the end."""
        return [*(participant for participant in self.cells if participant not in self._drawn), *self._drawn]

    def shows(self, participant: int, content: CellContent) -> bool:
        """Return whether the participant's cell looks as the content does."""
        drawn = self._drawn.get(participant)
        return drawn is not None and drawn.looks_like(content)

    def on_drawn(self, participant: int, content: CellContent) -> None:
        """Account for a content that has been drawn into a participant's cell."""
        self._drawn.pop(participant, None)
        self._drawn[participant] = content

    def copy_to(self, framebuffer: moderngl.Framebuffer) -> None:
        """Copy all cells into a framebuffer of the window's size."""
        self._ctx.copy_framebuffer(framebuffer, self.framebuffer)
